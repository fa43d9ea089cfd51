"""Which meshes are on record, in the bag of this run or in that of an earlier one."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from typing import TYPE_CHECKING

from rclpy.serialization import serialize_message

from ..messages.part_messages import part_message
from ..messages.times import now
from ..recorder import PART_MESH, Recorder
from .memory import Memory

if TYPE_CHECKING:
    from .part_store import KnownPart

Key = tuple[str, str]
"""Name and digest of a part."""

Override = tuple[float, float]
"""Restitution and drop height of a part's own scene."""

RECORDED = 4096
"""Meshes that are known to be in a bag."""


def _key(known: KnownPart) -> Key:
    return known.part.part_id, known.part.digest


class MeshRecord:
    """Puts each mesh on record once, and again before that record goes.

    A mesh counts as recorded while its mark in this run is trusted, or while the bag of the
    earlier run stays in which it lies, and what this run's first file says of that.

    Attributes `coming`: meshes of earlier runs whose parts are not known yet.
    """

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._recorded: Memory[Key, tuple[Override, int]] = Memory(RECORDED)
        self._elsewhere: dict[Key, tuple[Override, str]] = {}
        self._distrusted: set[str] = set()
        self.coming: set[Key] = set()
        self._lock = threading.Lock()  # held while nothing else is called

    def record(self, known: KnownPart) -> None:
        """Put a part's mesh on record, unless it is there with the same scene of its own.

        The result that is latched next goes on record too: it tells the mesh's digest.
        """
        request = known.request
        if request is None or self.holds(known):
            return
        known.mesh_is_last = True
        message = part_message(request, known.part.part_id, request.stamp or now())
        mark = self._recorder.mark
        if self._recorder.record(PART_MESH, serialize_message(message)):
            self._recorded.put(_key(known), (known.scene_override, mark))

    def holds(self, known: KnownPart) -> bool:
        """Whether a part's mesh is on record with the same scene of its own, and stays there."""
        if known.request is None:
            return True
        key, trusted_from = _key(known), self._recorder.trusted_from
        override, mark = self._recorded.get(key) or (None, -1)
        if override == known.scene_override and mark >= trusted_from:
            return True
        with self._lock:
            override, run = self._elsewhere.get(key) or (None, "")
            return (override == known.scene_override and not trusted_from
                    and run not in self._distrusted)

    def must_move(self, known: KnownPart) -> bool:
        """Whether a part's mesh lies in a distrusted run, and perhaps nowhere else."""
        with self._lock:
            _, run = self._elsewhere.get(_key(known)) or (None, "")
            return run in self._distrusted

    def count_as_recorded(self, key: Key, override: Override, run: str) -> None:
        """Take a mesh for recorded that lies in the bag of an earlier run and is coming."""
        with self._lock:
            self.coming.add(key)
            self._elsewhere[key] = override, run

    def distrust(self, run: str) -> bool:
        """Count no mesh in the bag of an earlier run as recorded; whether there are any."""
        with self._lock:
            needed = any(run == one for _, one in self._elsewhere.values())
            if needed:
                self._distrusted.add(run)
            return needed

    def leave_runs(self, parts: Iterable[KnownPart]) -> None:
        """Note that what known parts need of distrusted runs was recorded again.

        Meshes of which that failed stay where they are, and so do those still to come.
        """
        if not self._distrusted:
            return
        missing = {_key(known) for known in parts if not self.holds(known)}
        if not self._recorder.sync():
            return
        with self._lock:
            for key, (_, run) in list(self._elsewhere.items()):
                if run in self._distrusted and key not in missing | self.coming:
                    del self._elsewhere[key]
            self._distrusted &= {run for _, run in self._elsewhere.values()}
