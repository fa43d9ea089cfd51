"""Which of the meshes recorded under a part's name is the present one.

Each mesh is recorded once, so where an earlier one came back under its name, only the
results that follow tell, by their digest.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from ..parts.part_requests import PartRequest


class Place(NamedTuple):
    """Where a mesh is: number of the bag, and of the message in it."""

    bag: int
    message: int


class CurrentMeshes:
    """Follows meshes and results in the order in which they were recorded.

    Of each part only the newest mesh is kept.
    """

    def __init__(self) -> None:
        self._newest: dict[str, tuple[Place, PartRequest]] = {}
        self._places: dict[tuple[str, str], Place] = {}
        self._present: dict[str, Place] = {}
        self._unseen: set[str] = set()

    def note_mesh(self, request: PartRequest, place: Place) -> None:
        """The next mesh."""
        self._newest[request.part_id] = place, request
        self._unseen.add(request.part_id)
        self._make_present(request.part_id, place)

    def note_result(self, part_id: str, digest: str) -> None:
        """The next result; the first one after a new mesh tells that mesh's digest."""
        if part_id in self._unseen:
            self._unseen.remove(part_id)
            self._places[part_id, digest] = self._newest[part_id][0]
        place = self._places.get((part_id, digest))
        if place is not None and place != self._present.get(part_id):
            self._make_present(part_id, place)

    def forget(self, part_id: str) -> None:
        """The part was forgotten; its meshes stay on record, if it comes again."""
        self._present.pop(part_id, None)

    def present(self, again: Iterable[tuple[Place, PartRequest]]) -> dict[str, PartRequest]:
        """The present mesh of each part, in the order in which they became that.

        Parameters
        ----------
        again : iterable of (Place, PartRequest)
            All meshes once more; read only if an earlier one came back.
        """
        found = {part_id: self._newest[part_id][1] for part_id in self._present}
        wanted = {place: part_id for part_id, place in self._present.items()
                  if place != self._newest[part_id][0]}
        for place, request in again if wanted else ():
            if place in wanted:
                found[wanted[place]] = request
        return found

    def _make_present(self, part_id: str, place: Place) -> None:
        self._present.pop(part_id, None)
        self._present[part_id] = place
