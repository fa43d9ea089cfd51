"""What stands in a dataset, and whether it fits together."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .spec import DatasetSpec

Arrays = dict[str, NDArray[Any]]


class Field(NamedTuple):
    """An array of the file: its shape in letters, its numbers' kind, and its meaning."""

    shape: tuple[str | int, ...]
    kind: str
    meaning: str


FIELDS: Final = {
    "vertices": Field(("B",), "u4", "vertices of each body"),
    "triangles": Field(("B",), "u4", "triangles of each body"),
    "poses": Field(("B",), "u4", "stable poses of each body, one a stable face"),
    "redraws": Field(("B",), "u4", "bodies thrown away before each body"),
    "vertex": Field(("V", 3), "f8", "vertices of all bodies, body after body; unit: the largest "
                    "distance of a vertex from the body's centroid, which is the origin"),
    "triangle": Field(("T", 3), "u4", "triangles of all bodies, counter-clockwise from outside; "
                      "vertices numbered from 0 in each body"),
    "center_of_mass": Field(("B", 3), "f8", "shifted centre of mass; the inertia is the "
                            "homogeneous body's about its centroid"),
    "down": Field(("P", 3), "f8", "unit vector that points down in each pose, poses of a body by "
                  "rising height"),
    "height": Field(("P",), "f8", "height of the centre of mass in each pose"),
    "count": Field(("P", "R", "K"), "u4", "drops that came to rest in each pose, at each "
                   "restitution, in each block of successive drops"),
    "settled": Field(("B", "R", "K"), "u4", "drops that came to rest at all"),
}
"""B bodies, V vertices, T triangles, P poses in all; R restitutions; K blocks."""


def check_arrays(arrays: Arrays, spec: DatasetSpec, bodies: int) -> None:
    """Refuse arrays that cannot be these bodies of this dataset.

    Raises
    ------
    ValueError
        With what is wrong, in words.
    """
    for name, field in FIELDS.items():
        found = arrays[name]
        if found.dtype != np.dtype(field.kind) or found.ndim != len(field.shape):
            raise ValueError(f"{name} of kind {found.dtype.str[1:]} in {found.ndim} dimensions")
    sizes: dict[str | int, int] = {
        "B": bodies, "R": len(spec.restitutions), "K": len(spec.block_ends),
        **{letter: int(arrays[name].sum(dtype=np.int64)) for letter, name in
           (("V", "vertices"), ("T", "triangles"), ("P", "poses"))}}
    for name, field in FIELDS.items():
        shape = tuple(sizes.get(letter, letter) for letter in field.shape)
        if arrays[name].shape != shape:
            raise ValueError(f"{name} of shape {arrays[name].shape} in place of {shape}")
    for name in ("vertices", "triangles", "poses"):
        if not arrays[name].all():
            raise ValueError(f"a body without {name}")
    if not all(np.isfinite(arrays[name]).all() for name in ("vertex", "center_of_mass", "down")):
        raise ValueError("a coordinate that is no number")
    if (arrays["triangle"] >= np.repeat(arrays["vertices"], arrays["triangles"])[:, None]).any():
        raise ValueError("a triangle without a corner")
    _check_counts(arrays, spec)


def _check_counts(arrays: Arrays, spec: DatasetSpec) -> None:
    starts = np.cumsum(arrays["poses"], dtype=np.int64) - arrays["poses"]
    sums = np.add.reduceat(arrays["count"], starts, axis=0, dtype=np.int64)
    if (sums != arrays["settled"]).any():
        raise ValueError("counts that do not add up to the settled drops")
    if (arrays["settled"] > np.diff(spec.block_ends, prepend=0)).any():
        raise ValueError("more settled drops than there were")
