"""Which of the meshes recorded under a part's name is the present one.

Each mesh is recorded once, so where an earlier one came back under its name, only the
results that follow tell, by their digest.
"""

from __future__ import annotations

from collections.abc import Iterable

from .part_requests import PartRequest


class CurrentMeshes:
    """Follows meshes and results in the order in which they were recorded.

    Meshes are counted; of each part only the newest one is kept.
    """

    def __init__(self) -> None:
        self._count = 0
        self._newest: dict[str, tuple[int, PartRequest]] = {}
        self._numbers: dict[tuple[str, str], int] = {}
        self._present: dict[str, int] = {}
        self._unseen: set[str] = set()

    def note_mesh(self, request: PartRequest) -> None:
        """The next mesh."""
        self._newest[request.part_id] = self._count, request
        self._unseen.add(request.part_id)
        self._make_present(request.part_id, self._count)
        self._count += 1

    def note_result(self, part_id: str, digest: str) -> None:
        """The next result; the first one after a new mesh tells that mesh's digest."""
        if part_id in self._unseen:
            self._unseen.remove(part_id)
            self._numbers[part_id, digest] = self._newest[part_id][0]
        number = self._numbers.get((part_id, digest))
        if number is not None and number != self._present.get(part_id):
            self._make_present(part_id, number)

    def forget(self, part_id: str) -> None:
        """The part was forgotten; its meshes stay on record, if it comes again."""
        self._present.pop(part_id, None)

    def present(self, again: Iterable[PartRequest]) -> dict[str, PartRequest]:
        """The present mesh of each part, in the order in which they became that.

        Parameters
        ----------
        again : iterable of PartRequest
            All meshes once more; read only if an earlier one came back.
        """
        found = {part_id: self._newest[part_id][1] for part_id in self._present}
        wanted = {number: part_id for part_id, number in self._present.items()
                  if number != self._newest[part_id][0]}
        for number, request in enumerate(again if wanted else ()):
            if number in wanted:
                found[wanted[number]] = request
        return found

    def _make_present(self, part_id: str, number: int) -> None:
        self._present.pop(part_id, None)
        self._present[part_id] = number
