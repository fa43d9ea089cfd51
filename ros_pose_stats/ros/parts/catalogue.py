"""The parts that the node knows; the least recently used is forgotten."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

from ...errors import RequestError
from ...records import DropScene, Part
from .part_requests import PartRequest, shown


@dataclass(eq=False)
class KnownPart:
    """A part with what the node says of it at present.

    Attributes
    ----------
    part : Part
    content : bytes
        Digest of the mesh as it was sent.
    scene_override : (restitution, drop_height)
        Of the part's own scene; negative: the node's.
    request : PartRequest or None
        The mesh as it was sent.
    latched : object
        The current result's message; None before the first.
    restored : object
        The result of the last run that this one began with, if any.
    scene : DropScene or None
        That the latched result is for.
    published : float
        When it was published, by the monotonic clock.
    revision : int
        Of the newest result.
    shown : int
        Revision of what was latched last.
    """

    part: Part
    content: bytes
    scene_override: tuple[float, float]
    request: PartRequest | None = None
    latched: Any = None
    restored: Any = None
    scene: DropScene | None = None
    published: float = 0.0
    revision: int = 0
    shown: int = 0
    lock: threading.RLock = field(default_factory=threading.RLock)

    def ready(self) -> Future[Part]:
        """The part as a future that is done."""
        future: Future[Part] = Future()
        future.set_result(self.part)
        return future


class Catalogue:
    """Known parts by their id.

    Parameters
    ----------
    on_forgotten : callable
        Told the `KnownPart` that made room or was forgotten.
    """

    def __init__(self, on_forgotten: Callable[[KnownPart], object]) -> None:
        self._on_forgotten = on_forgotten
        self._parts: OrderedDict[str, KnownPart] = OrderedDict()
        self._lock = threading.Lock()

    def put(self, known: KnownPart, most: int) -> None:
        """Remember a part; takes the place of one of the same id, and of the oldest if full."""
        with self._lock:
            self._parts.pop(known.part.part_id, None)
            self._parts[known.part.part_id] = known
        self.shrink(most)

    def find(self, part_id: str) -> KnownPart | None:
        """A part, which counts as used now; None if it is not known."""
        with self._lock:
            known = self._parts.get(part_id)
            if known is not None:
                self._parts.move_to_end(part_id)
            return known

    def current(self, part_id: str) -> KnownPart | None:
        """A part without counting it as used; None if it is not known."""
        with self._lock:
            return self._parts.get(part_id)

    def known(self, part_id: str) -> KnownPart:
        """A part, which counts as used now.

        Raises
        ------
        RequestError
            If it is not known.
        """
        found = self.find(part_id)
        if found is None:
            names = sorted(self._parts)
            some = ", ".join(names[:8]) + (", …" if len(names) > 8 else "")
            raise RequestError("the part_id of a known part" + (f" ({some})" if some else ""),
                               shown(part_id), "publish its mesh on ~/part_mesh, or send the part "
                               "with the request")
        return found

    def forget(self, part_id: str) -> None:
        """Forget a part.

        Raises
        ------
        RequestError
            If it is not known.
        """
        self.known(part_id)
        with self._lock:
            known = self._parts.pop(part_id, None)
        if known is not None:
            self._on_forgotten(known)

    def all(self) -> list[KnownPart]:
        """All parts, the least recently used first."""
        with self._lock:
            return list(self._parts.values())

    def shrink(self, most: int) -> None:
        """Forget the least recently used ones beyond `most`."""
        with self._lock:
            too_many = [self._parts.popitem(last=False)[1]
                        for _ in range(len(self._parts) - most)]
        for forgotten in too_many:
            self._on_forgotten(forgotten)
