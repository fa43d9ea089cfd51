# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""The file of a dataset: a numpy archive with a schema of its contents."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.base.errors import reason
from ros_pose_stats.base.version import VERSION
from ros_pose_stats.tools.batch.folder import write_durably

from .spec import DatasetError, DatasetSpec

FORMAT: Final = "ros_pose_stats.dataset"
FORMAT_VERSION: Final = 1


def write_archive(file: Path, spec: DatasetSpec, chunks: Sequence[Arrays]) -> None:
    """Write pieces in the order of their bodies; equal pieces give equal bytes.

    The file appears whole or not at all.

    Raises
    ------
    BatchError
        If it cannot be written.
    """
    schema = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "written_by": f"ros_pose_stats {VERSION}",
        "spec": spec.as_dict(),
        "block_ends": spec.block_ends,
        "fields": {
            name: {"shape": list(field.shape), "meaning": field.meaning}
            for name, field in FIELDS.items()
        },
    }
    arrays = {
        name: np.concatenate([chunk[name] for chunk in chunks]) for name in FIELDS
    }
    whole: dict[str, Any] = {"schema": np.array(json.dumps(schema, indent=1)), **arrays}
    stream = io.BytesIO()
    np.savez_compressed(stream, **whole)
    write_durably(file, stream.getvalue())


def read_archive(file: Path) -> tuple[DatasetSpec, Arrays]:
    """Specification and arrays of a file.

    Raises
    ------
    DatasetError
        If it cannot be read, is of another kind, or contradicts itself.
    """
    try:
        with np.load(file, allow_pickle=False) as archive:
            schema = json.loads(str(archive["schema"]))
            format_name = f"{schema['format']} of version {schema['format_version']}"
            if format_name == f"{FORMAT} of version {FORMAT_VERSION}":
                spec = DatasetSpec.from_dict(schema["spec"])
                arrays = {name: archive[name] for name in FIELDS}
                check_arrays(arrays, spec, spec.bodies)
                return spec, arrays
    except OSError as error:
        raise DatasetError(
            "a readable file", f"{file} ({reason(error)})", "check the path"
        ) from error
    except Exception as error:  # numpy and zip raise a dozen kinds on damaged files
        raise DatasetError(
            "a dataset as `python -m study dataset` writes it",
            f"{file} ({reason(error)})",
            "make it anew",
        ) from error
    raise DatasetError(
        f"a {FORMAT} of version {FORMAT_VERSION}",
        f"{format_name} in {file}",
        "make it anew with `python -m study dataset`",
    )


Arrays = dict[str, NDArray[Any]]


class Field(NamedTuple):
    """An array of the file: its shape in letters, the type of its numbers, and its
    meaning.
    """

    shape: tuple[str | int, ...]
    kind: str
    meaning: str


FIELDS: Final = {
    "vertices": Field(("B",), "u4", "vertices of each body"),
    "triangles": Field(("B",), "u4", "triangles of each body"),
    "poses": Field(("B",), "u4", "stable poses of each body, one a stable face"),
    "redraws": Field(("B",), "u4", "bodies thrown away before each body"),
    "vertex": Field(
        ("V", 3),
        "f8",
        "vertices of all bodies, body after body; unit: the largest "
        "distance of a vertex from the body's centroid, which is the origin",
    ),
    "triangle": Field(
        ("T", 3),
        "u4",
        "triangles of all bodies, counter-clockwise from outside; "
        "vertices numbered from 0 in each body",
    ),
    "center_of_mass": Field(
        ("B", 3),
        "f8",
        "shifted centre of mass; the inertia is the "
        "homogeneous body's about its centroid",
    ),
    "down": Field(
        ("P", 3),
        "f8",
        "unit vector that points down in each pose, poses of a body by rising height",
    ),
    "height": Field(("P",), "f8", "height of the centre of mass in each pose"),
    "count": Field(
        ("P", "R", "K"),
        "u4",
        "drops that came to rest in each pose, at each "
        "restitution, in each block of successive drops",
    ),
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
        array = arrays[name]
        if array.dtype != np.dtype(field.kind) or array.ndim != len(field.shape):
            raise ValueError(
                f"{name} of kind {array.dtype.str[1:]} in {array.ndim} dimensions"
            )
    sizes: dict[str | int, int] = {
        "B": bodies,
        "R": len(spec.restitutions),
        "K": len(spec.block_ends),
        **{
            letter: int(arrays[name].sum(dtype=np.int64))
            for letter, name in (("V", "vertices"), ("T", "triangles"), ("P", "poses"))
        },
    }
    for name, field in FIELDS.items():
        shape = tuple(sizes.get(letter, letter) for letter in field.shape)
        if arrays[name].shape != shape:
            raise ValueError(
                f"{name} of shape {arrays[name].shape} in place of {shape}"
            )
    for name in ("vertices", "triangles", "poses"):
        if not arrays[name].all():
            raise ValueError(f"a body without {name}")
    if not all(
        np.isfinite(arrays[name]).all() for name in ("vertex", "center_of_mass", "down")
    ):
        raise ValueError("a coordinate that is no number")
    if (
        arrays["triangle"]
        >= np.repeat(arrays["vertices"], arrays["triangles"])[:, None]
    ).any():
        raise ValueError("a triangle without a corner")
    _check_counts(arrays, spec)


def _check_counts(arrays: Arrays, spec: DatasetSpec) -> None:
    starts = np.cumsum(arrays["poses"], dtype=np.int64) - arrays["poses"]
    sums = np.add.reduceat(arrays["count"], starts, axis=0, dtype=np.int64)
    if (sums != arrays["settled"]).any():
        raise ValueError("counts that do not add up to the settled drops")
    if (arrays["settled"] > np.diff(spec.block_ends, prepend=0)).any():
        raise ValueError("more settled drops than there were")
