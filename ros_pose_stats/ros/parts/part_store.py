"""What parts the node knows: built once, put on record once, the least recently used forgotten."""

from __future__ import annotations

import math
import threading
from collections import OrderedDict, deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import TypeVar

from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import PoseStatistics

from ...errors import PoseStatsError, RequestError
from ...records import DropScene, Part
from ...records.part import digest_name
from ..messages.part_messages import part_message
from ..messages.times import now
from ..recorder import PART_MESH, Recorder
from .memory import Memory
from .part_requests import PartRequest, part_of, shown

T = TypeVar("T")

REFUSED = 1024
"""Refused meshes kept for when they come again."""

BUILT = 16
"""Parts kept after another mesh of the same name has come: the first may come again."""

RECORDED = 4096
"""Meshes that are known to be in the bag."""

NUMBERED = 1024
"""Forgotten parts whose revisions go on where they come again."""


@dataclass(eq=False)
class Revisions:
    """Numbers of the results of one name, whichever meshes come under it.

    Attributes
    ----------
    newest : int
        Given to a result.
    shown : int
        Of what was latched last.
    recorded : deque of int
        Numbers of the last results that were put on record when latched, as they were first.
    recorded_at : float
        When that was last, by the monotonic clock.
    lock : RLock
        Held while a result of the name is numbered, latched or withdrawn.
    """

    newest: int = 0
    shown: int = 0
    recorded: deque[int] = field(default_factory=lambda: deque(maxlen=BUILT))
    recorded_at: float = -math.inf
    lock: threading.RLock = field(default_factory=threading.RLock)

    def next(self) -> int:
        """The number of a new result."""
        with self.lock:
            self.newest += 1
            return self.newest


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
    revisions : Revisions
        Of its name.
    latched : PoseStatistics or None
        The current result, which late joiners get.
    scene : DropScene or None
        That the latched result is for.
    published : float
        When it was published, by the monotonic clock.
    on_record : PoseStatistics or None
        The result of the last run that this one began with, which is in the bag already.
    origin : PoseStatistics or None
        The latched result as it was before it got another number to be latched under.
    mark : int
        The recorder's, when the latched result was put on record; -1 where it is not.
    latched_bytes : int
        Size of the latched result as a message.
    mesh_is_last : bool
        Whether the mesh went on record, and no result of it since.
    """

    part: Part
    content: bytes
    scene_override: tuple[float, float]
    request: PartRequest | None = None
    revisions: Revisions = field(default_factory=Revisions)
    latched: PoseStatistics | None = None
    scene: DropScene | None = None
    published: float = 0.0
    on_record: PoseStatistics | None = None
    origin: PoseStatistics | None = None
    mark: int = -1
    latched_bytes: int = 0
    mesh_is_last: bool = False


def at_hand(value: T) -> Future[T]:
    """A future that is done."""
    future: Future[T] = Future()
    future.set_result(value)
    return future


class PartStore:
    """Known parts by their id.

    Parameters
    ----------
    recorder : Recorder
    on_forgotten : callable
        Told the id of a part that made room or was forgotten.
    """

    def __init__(self, recorder: Recorder, on_forgotten: Callable[[str], object]) -> None:
        self._recorder = recorder
        self._on_forgotten = on_forgotten
        self._parts: OrderedDict[str, KnownPart] = OrderedDict()
        self._lock = threading.Lock()
        self._refused: Memory[tuple[str, bytes], PoseStatsError] = Memory(REFUSED)
        self._built: Memory[tuple[str, bytes], Part] = Memory(BUILT)
        self._recorded: Memory[tuple[str, str], tuple[tuple[float, float], int]] = Memory(
            RECORDED)
        self._revisions: Memory[str, Revisions] = Memory(NUMBERED)

    def resolve(self, request: PartRequest) -> tuple[KnownPart, bool]:
        """The part that a mesh is, and whether it is new: not known yet, and here by `put` only.

        Raises
        ------
        PoseStatsError
            With one line that says what is wrong; at once where the mesh was refused before.
        """
        same = self._same(request.part_id, request.content)
        part = self._build(request) if same is None else same.part
        old = self.find(part.part_id)
        override = (request.restitution, request.drop_height)
        if old is not None and (old.part.digest, old.scene_override) == (part.digest, override):
            return old, False
        revisions = self._revisions.get(part.part_id) if old is None else old.revisions
        return KnownPart(part, request.content, override, request,
                         revisions or Revisions()), True

    def _same(self, part_id: str, content: bytes) -> KnownPart | None:
        """The known part of this name and mesh; by the mesh alone where there is no name."""
        if part_id:
            known = self.find(part_id)
            return known if known is not None and known.content == content else None
        for known in self.all():
            if known.content == content and known.part.part_id == digest_name(known.part.digest):
                return self.find(known.part.part_id)
        return None

    def _build(self, request: PartRequest) -> Part:
        key = request.part_id, request.content
        refusal = self._refused.get(key)
        if refusal is not None:
            raise refusal
        part = self._built.get(key)
        if part is None:
            try:
                part = part_of(request)
            except PoseStatsError as found:
                self._refused.put(key, found)
                raise
            self._built.put(key, part)
        return part

    def put(self, known: KnownPart, most: int) -> None:
        """Record and remember a part, with no result of the same name between the two.

        It takes the place of one of the same id, and of the oldest if there are `most`.
        """
        with known.revisions.lock:
            trusted = self._recorder.trusted_from
            self.record(known)
            with self._lock:
                self._parts.pop(known.part.part_id, None)
                self._parts[known.part.part_id] = known
            if self._recorder.trusted_from != trusted:  # while nobody knew the part
                self.record(known)
        self.shrink(most)

    def record(self, known: KnownPart) -> None:
        """Put a part's mesh on record, unless it is there with the same scene of its own.

        The result that is latched next goes on record too: it tells the mesh's digest.
        """
        if not self.has_recorded(known) and known.request is not None:
            known.mesh_is_last = True
            self.record_mesh(known.request, known.part.part_id, known.part.digest)

    def record_mesh(self, request: PartRequest, part_id: str, digest: str) -> None:
        """Put a mesh on record under its final name, unless it is there."""
        if self._has_recorded(request, part_id, digest):
            return
        message, mark = part_message(request, part_id, request.stamp or now()), self._recorder.mark
        if self._recorder.record(PART_MESH, serialize_message(message)):
            override = request.restitution, request.drop_height
            self._recorded.put((part_id, digest), (override, mark))

    def has_recorded(self, known: KnownPart) -> bool:
        """Whether a part's mesh is in the bag, and stays there for now."""
        return known.request is None or self._has_recorded(
            known.request, known.part.part_id, known.part.digest)

    def _has_recorded(self, request: PartRequest, part_id: str, digest: str) -> bool:
        override, mark = self._recorded.get((part_id, digest)) or (None, -1)
        return (override == (request.restitution, request.drop_height)
                and mark >= self._recorder.trusted_from)

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
            with self._lock:
                names = sorted(self._parts)
            some = ", ".join(names[:8]) + (", …" if len(names) > 8 else "")
            raise RequestError("the part_id of a known part" + (f" ({some})" if some else ""),
                               shown(part_id), "publish its mesh on ~/part_mesh, or send the part "
                               "with the request")
        return found

    def all(self) -> list[KnownPart]:
        """All parts, the least recently used first."""
        with self._lock:
            return list(self._parts.values())

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
            self._let_go(known)

    def shrink(self, most: int) -> None:
        """Forget the least recently used ones beyond `most`."""
        with self._lock:
            too_many = [self._parts.popitem(last=False)[1]
                        for _ in range(len(self._parts) - most)]
        for forgotten in too_many:
            self._let_go(forgotten)

    def _let_go(self, known: KnownPart) -> None:
        with known.revisions.lock:  # what is being latched is withdrawn afterwards
            self._on_forgotten(known.part.part_id)
            known.revisions.shown = known.revisions.newest
            self._revisions.put(known.part.part_id, known.revisions)
