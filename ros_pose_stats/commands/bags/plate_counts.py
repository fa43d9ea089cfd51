"""What cameras counted on one plate, out of bags, with the parts that were counted."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from ...errors import PoseStatsError, RequestError
from ...mesh.parts import part_from_mesh
from ...plates import CountedPart, count_part
from ...recording.analysis import CameraCounts, read_bags
from ...recording.analysis.bag_reader import OnProgress
from ...recording.analysis.part_meshes import PartMeshRecord, read_part_meshes
from ...records import Part
from ...text import listed, several


def counts_on_plate(paths: Sequence[Path], plate: str,
                    on_progress: OnProgress | None = None
                    ) -> tuple[list[CountedPart], list[str]]:
    """Read the counts of a plate, and the meshes of the parts from the same bags.

    Counts that name no plate are taken too, as those of the only plate there was.

    Returns `counted`; `notes`: what could not be used, one sentence each. Raises BagError,
    RequestError if there is no bag, or nothing was counted on this plate.
    """
    told = read_bags(paths, on_progress).counts
    wanted = [one for one in told if one.plate in ("", plate) and one.classified]
    if not wanted:
        plates = sorted({one.plate for one in told if one.plate})
        raise RequestError(f"counts of cameras on plate {plate}",
                           f"those of {listed(plates)}" if plates else "none",
                           "name its plate, or record ~/pose_counts")
    parts = _parts_of(wanted, read_part_meshes(paths))
    counted, notes = [], []
    for one in wanted:
        found = _join(one, parts)
        if isinstance(found, CountedPart):
            counted.append(found)
        else:
            notes.append(f"{several(one.classified, 'count')} of {one.part_id} left out: {found}")
    return counted, notes


def _parts_of(wanted: Iterable[CameraCounts],
              meshes: Iterable[PartMeshRecord]) -> dict[str, Part]:
    """Parts by digest, of all meshes in the bags until those counted are there."""
    missing = {one.part_digest for one in wanted}
    found: dict[str, Part] = {}
    for mesh in meshes:
        part = _built(mesh)
        if part is not None:
            found.setdefault(part.digest, part)
            missing.discard(part.digest)
        if not missing:
            break
    return found


def _built(mesh: PartMeshRecord) -> Part | None:
    given = mesh.mass != 0.0
    try:
        return part_from_mesh(
            mesh.vertices, mesh.triangles, mesh.center_of_mass if given else None,
            mesh.mass if given else None,
            mesh.inertia if given and np.any(mesh.inertia) else None,
            part_id=mesh.part_id, unit=mesh.unit)
    except PoseStatsError:
        return None  # one that the node refused too; a part without a mesh is named by its counts


def _join(one: CameraCounts, parts: dict[str, Part]) -> CountedPart | str:
    """The counts with their part, or why they cannot be used."""
    fitting = ([parts[one.part_digest]] if one.part_digest in parts else
               [part for part in parts.values()
                if part.part_id == one.part_id and not one.part_digest])
    if len(fitting) != 1:
        return ("several parts have this name, and the counts carry no digest" if fitting
                else "its mesh is not in the bags")
    if math.isnan(one.numbering.cluster_tolerance):
        return "they do not say by which cluster_tolerance the poses are numbered"
    try:
        return count_part(fitting[0], dict(zip(one.index.tolist(), one.count.tolist(),
                                               strict=True)),
                          cluster_tolerance=one.numbering.cluster_tolerance,
                          round_sides=one.numbering.round_sides)
    except PoseStatsError as error:
        return str(error)
