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
    """Puts each mesh on record once."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._recorded: Memory[Key, Override] = Memory(RECORDED)
        self._elsewhere: dict[Key, str] = {}
        self._lock = threading.Lock()

    def record(self, known: KnownPart) -> None:
        """Put a part's mesh on record, unless it is there with the same scene of its own."""
        request = known.request
        if request is None or self.holds(known):
            return
        message = part_message(request, known.part.part_id, request.stamp or now())
        if self._recorder.record(PART_MESH, serialize_message(message)):
            self._recorded.put(_key(known), known.scene_override)

    def holds(self, known: KnownPart) -> bool:
        """Whether a part's mesh is on record with the same scene of its own."""
        return self._recorded.get(_key(known)) == known.scene_override

    def count_as_recorded(self, key: Key, override: Override, run: str) -> None:
        """Take a mesh for recorded that lies in the bag of an earlier run."""
        self._recorded.put(key, override)
        with self._lock:
            self._elsewhere[key] = run

    def needs_run(self, run: str) -> bool:
        """Whether meshes lie in the bag of an earlier run and perhaps nowhere else."""
        with self._lock:
            return run in self._elsewhere.values()

    def distrust(self, run: str | None = None) -> None:
        """Count no mesh as recorded any more, or none in the bag of an earlier run."""
        if run is None:
            self._recorded.clear()
        for key in self._in_run(run):
            self._recorded.drop(key)

    def leave_run(self, run: str | None, parts: Iterable[KnownPart]) -> None:
        """Note that what known parts need of an earlier run (of all) was recorded again.

        Meshes of which that failed stay where they are.
        """
        self._recorder.sync()
        missing = {_key(known) for known in parts if not self.holds(known)}
        for key in self._in_run(run):
            if key not in missing:
                with self._lock:
                    self._elsewhere.pop(key, None)

    def _in_run(self, run: str | None) -> list[Key]:
        """Meshes in the bag of an earlier run, of any for None."""
        with self._lock:
            return [key for key, one in self._elsewhere.items() if run in (None, one)]
