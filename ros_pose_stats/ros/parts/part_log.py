"""Meshes on record, each once a digest."""

from __future__ import annotations

from rclpy.serialization import serialize_message

from ..messages.part_messages import part_message
from ..messages.times import now
from ..recorder import PART_MESH, Recorder
from .memory import Memory
from .part_requests import PartRequest

REMEMBERED = 4096


class PartLog:
    """Puts meshes on record unless they are there.

    Parameters
    ----------
    recorder : Recorder
    """

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self._overrides: Memory[tuple[str, str], tuple[float, float]] = Memory(REMEMBERED)

    def note(self, request: PartRequest, part_id: str, digest: str) -> None:
        """Put a mesh on record, unless it is there with the same scene of its own."""
        key, override = (part_id, digest), (request.restitution, request.drop_height)
        if self._overrides.get(key) == override:
            return
        message = part_message(request, part_id, request.stamp or now())
        if self._recorder.record(PART_MESH, serialize_message(message)):
            self._overrides.put(key, override)

    def begin_again(self) -> None:
        """The bag may have a gap: nothing counts as recorded any more."""
        self._overrides.clear()
