"""Which of the meshes recorded under a part's name is the present one, and where it lies."""

from __future__ import annotations

from dataclasses import dataclass

from .places import Place


@dataclass(eq=False)
class RecordedMesh:
    """A mesh in a bag."""

    place: Place
    restitution: float  # of the part's own scene, as the mesh has it; negative: the node's
    drop_height: float
    digest: str = ""  # of the part; empty until a result has told it


class CurrentMeshes:
    """Follows meshes and results in the order in which they were recorded.

    Each mesh is recorded once, so where an earlier one came back under its name, only the
    results that follow tell, by their digest.
    """

    def __init__(self) -> None:
        self._newest: dict[str, RecordedMesh] = {}
        self._known: dict[tuple[str, str], RecordedMesh] = {}
        self._present: dict[str, RecordedMesh] = {}

    def note_mesh(self, part_id: str, mesh: RecordedMesh) -> None:
        """The next mesh."""
        self._newest[part_id] = mesh
        self._make_present(part_id, mesh)

    def note_restored(self, part_id: str, mesh: RecordedMesh) -> None:
        """A mesh that an earlier run recorded; its digest is known if it ever was."""
        self.note_mesh(part_id, mesh)
        if mesh.digest:
            self._known[part_id, mesh.digest] = mesh

    def note_result(self, part_id: str, digest: str) -> None:
        """The next result; the first one after a new mesh tells that mesh's digest."""
        newest = self._newest.get(part_id)
        if newest is not None and not newest.digest:
            newest.digest = digest
            self._known[part_id, digest] = newest
        mesh = self._known.get((part_id, digest))
        if mesh is not None and mesh is not self._present.get(part_id):
            self._make_present(part_id, mesh)

    def note_use(self, part_id: str) -> None:
        """The part was asked for."""
        mesh = self._present.get(part_id)
        if mesh is not None:
            self._make_present(part_id, mesh)

    def forget(self, part_id: str) -> None:
        """The part was forgotten; its meshes stay on record, if it comes again."""
        self._present.pop(part_id, None)

    def present(self) -> dict[str, RecordedMesh]:
        """The present mesh of each part, the least recently used part first."""
        return dict(self._present)

    def _make_present(self, part_id: str, mesh: RecordedMesh) -> None:
        self._present.pop(part_id, None)
        self._present[part_id] = mesh
