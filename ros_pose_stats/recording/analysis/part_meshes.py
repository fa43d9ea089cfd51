"""The meshes of parts that lie in bags."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .bag_files import FileMessages, find_bags
from .decoding import PART_MESH, Decoders, kind_of

Array = NDArray[np.float64]


class PartMeshRecord(NamedTuple):
    """A part as it was recorded; see the message PartMesh."""

    part_id: str
    vertices: Array  # (V, 3); in `unit`
    triangles: NDArray[np.uint32]  # (T, 3)
    unit: float  # metres
    mass: float  # kilograms; 0 where all of it is from the mesh
    center_of_mass: Array  # (3,); metres
    inertia: Array  # (3, 3); kg m²; zero where it is from the mesh


def read_part_meshes(paths: Iterable[Path]) -> Iterator[PartMeshRecord]:
    """Every mesh in bags, in the order of recording; what is broken is left out.

    Raises BagError if there is no bag.
    """
    decoders = Decoders()
    for files in find_bags(paths).values():
        for file in files:
            for message in FileMessages(file, lambda share: None):
                if kind_of(message.type_name) == PART_MESH:
                    decoded = decoders.decode(message)
                    record = None if decoded is None else _record(decoded)
                    if record is not None:
                        yield record


def _record(message: Any) -> PartMeshRecord | None:
    try:
        corners, numbers = list(message.vertices), list(message.triangles)
        if not numbers:
            nested = message.mesh
            corners = [x for p in nested.vertices for x in (p.x, p.y, p.z)]
            numbers = [k for triangle in nested.triangles for k in triangle.vertex_indices]
        vertices = np.array(corners, dtype=np.float64).reshape(-1, 3)
        triangles = np.array(numbers, dtype=np.uint32).reshape(-1, 3)
        given = message.inertia
        tensor = np.array([[given.ixx, given.ixy, given.ixz], [given.ixy, given.iyy, given.iyz],
                           [given.ixz, given.iyz, given.izz]], dtype=np.float64)
        center = np.array([given.com.x, given.com.y, given.com.z], dtype=np.float64)
        return PartMeshRecord(str(message.part_id), vertices, triangles, float(message.unit),
                              float(given.m), center, tensor)
    except (AttributeError, TypeError, ValueError):
        return None  # a definition of another kind under our name
