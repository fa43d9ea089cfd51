"""From meshes as they are sent to parts; what came lately is not built anew."""

from __future__ import annotations

from ...errors import PoseStatsError
from ...records import Part
from .memory import Memory
from .part_requests import PartRequest, part_of

REFUSED = 1024
"""Refused meshes kept for when they come again."""

BUILT = 16
"""Parts kept after another mesh of the same name has come: the first may come again."""


class PartBuilder:
    """Builds parts."""

    def __init__(self) -> None:
        self._refused: Memory[tuple[str, bytes], PoseStatsError] = Memory(REFUSED)
        self._built: Memory[tuple[str, bytes], Part] = Memory(BUILT)

    def build(self, request: PartRequest) -> Part:
        """The part of a request.

        Raises
        ------
        PoseStatsError
            With one line that says what is wrong; at once where the mesh was refused before.
        """
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
