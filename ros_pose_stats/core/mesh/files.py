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

"""Mesh files: STL, OBJ, PLY, OFF, 3MF and STEP to arrays, and arrays to STL.

Binary STL, which is the most common, is only a table of numbers; all else is read in a
process of its own. This module does the rest. Nothing is merged, reordered or repaired,
so that a part's digest depends on the file alone; a file that says less than it
announces (cut off by a full disk, say) is refused; and the objects of a scene are set
in place by their transforms and joined into one mesh.
"""

import hashlib
import importlib.util
import json
import math
import os
import subprocess
import sys
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...base import extras
from ...base.caches import BoundedCache
from ...base.errors import MeshFileError, TimedOutError, reason
from ...base.files import NotAFileError, open_file
from ..records import Array, Corners, Index
from . import units, vectors

PlacedMesh = tuple[Array, Index, Array]
"""Vertices (V, 3) and triangles (T, 3) of an object, and the matrix (4, 4) that places
it."""

STEP_SUFFIXES = (".step", ".stp")

_MOST_SECONDS = 120.0
"""A part of ten thousand faces takes some seconds; what takes longer is a whole
machine."""

_PACKAGES = str(Path(__file__).parents[3])
_PROGRAM = (
    "import sys; sys.path.append(sys.argv[1]); "
    f"from {__package__}.reading_process import main; "
    "main(int(sys.argv[2]), sys.argv[3], int(sys.argv[4]), sys.argv[5])"
)

_OUT_OF_MEMORY = (b"MemoryError", b"bad_alloc", b"OutOfMemory")
"""What Python, C++ and OpenCASCADE print."""

MOST_BYTES = 2**29
"""Of a file, and of a mesh's arrays: some ten million triangles."""

TESSELLATIONS = BoundedCache("tessellations", 2**28)
"""A STEP file takes seconds, and is read by one command after the other."""

SUFFIXES = (".stl", ".obj", ".ply", ".off", ".3mf", *STEP_SUFFIXES)

_STL_TRIANGLE = np.dtype(
    [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
)


class FileMesh(NamedTuple):
    """The mesh of a file."""

    # (V, 3) array_like; in the file's unit, in the order of the file, not merged
    vertices: Any
    triangles: Any  # (T, 3) array_like of int
    unit: float  # metres a unit
    unit_guessed: bool = False  # from the size, since the file names none
    # metres a unit as the file declares, whichever counts; None for files that declare
    # none
    declared: float | None = None
    # whether the file is of solids, so that a surface with holes has lost something
    of_solids: bool = False


def read_mesh(
    file: str | os.PathLike[str],
    unit: str | float | None = None,
    *,
    unless_declared: bool = False,
    most_bytes: int = MOST_BYTES,
) -> "FileMesh":
    """Vertices and triangles of a mesh file.

    `unit` and `unless_declared` as for `load_part`; `most_bytes`: of the file, and of
    the mesh's arrays.
    """
    if not isinstance(file, (str, os.PathLike)):
        raise MeshFileError(
            "the path of a mesh file",
            f"{type(file).__name__}",
            "give arrays to part_from_mesh instead",
        )
    path = Path(file)
    return parse_mesh(
        path,
        read_bytes(path, most_bytes),
        unit,
        unless_declared=unless_declared,
        most_bytes=most_bytes,
    )


def parse_mesh(
    path: Path,
    content: bytes,
    unit: str | float | None = None,
    *,
    unless_declared: bool = False,
    most_bytes: int = MOST_BYTES,
) -> "FileMesh":
    """The same of what a file holds; `path`: for the format, and for messages.

    `most_bytes`: of the mesh's arrays.
    """
    requested = units.requested_unit(unit)
    suffix = path.suffix.lower()
    declared = None
    if suffix == ".stl" and b"\0" in content:
        vertices, triangles = _read_binary_stl(path, content, most_bytes)
    else:
        declared, objects = read_in_process(path, content, most_bytes)
        vertices, triangles = _join_meshes(objects)
    of_solids = suffix in STEP_SUFFIXES
    if of_solids and declared is not None:
        # They came in float32, and it has to show: whoever asks for their rounding
        # looks for it.
        vertices = (vertices / declared).astype(np.float32).astype(np.float64)
    if len(triangles) == 0:
        raise MeshFileError(
            f"triangles in {path}",
            "none",
            "the file is empty, cut off, or holds only points or curves",
        )
    if declared is not None and (unless_declared or requested is None):
        requested = declared
    if requested is not None:
        return FileMesh(vertices, triangles, requested, False, declared, of_solids)
    extent = units.extent_of(vertices, triangles)
    # What has no extent is refused where a part is to be made of it.
    is_guessed = not math.isnan(extent)
    return FileMesh(vertices, triangles, units.guess_unit(extent), is_guessed)


def _read_binary_stl(path: Path, data: bytes, most_bytes: int) -> tuple[Array, Index]:
    """The table of triangles, without what may lie behind it."""
    count = int.from_bytes(data[80:84], "little")
    length = 84 + 50 * count
    if len(data) < length or (len(data) > length and count == 0):
        raise MeshFileError(
            "a readable STL file of the length that its header announces",
            f"{path} of {len(data)} bytes where {count} triangles take {length}",
            "the file is cut off or damaged: export it again",
        )
    if 96 * count > most_bytes:  # nine coordinates and three corners of 8 bytes
        raise MeshFileError(
            f"a mesh of at most {most_bytes / 1e6:.4g} MB in memory",
            f"{path} of {count} triangles, which take {96e-6 * count:.4g} MB",
            "decimate it, or export single parts",
        )
    corners = np.frombuffer(data, _STL_TRIANGLE, count, offset=84)["corners"]
    vertices: Array = corners.reshape(-1, 3).astype(np.float64)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


def _join_meshes(objects: Iterable[PlacedMesh]) -> tuple[Array, Index]:
    """Join objects, each in its place, and rewind those that are mirrored."""
    vertices: list[Array] = [np.zeros((0, 3))]
    triangles: list[Index] = [np.zeros((0, 3), dtype=np.int64)]
    offset = 0
    for points, corners, transform in objects:
        if not np.array_equal(transform, np.eye(4)):
            a, b, c = transform[:3, :3]
            # What leaves the range of float64 is refused with the mesh.
            with np.errstate(over="ignore", invalid="ignore"):
                points = (
                    vectors.turn_vectors(points, transform[:3, :3].T) + transform[:3, 3]
                )
                is_mirrored = float((np.cross(a, b) * c).sum()) < 0.0
            if is_mirrored:
                corners = corners[:, ::-1]
        vertices.append(points)
        triangles.append(corners + offset)
        offset += len(points)
    return np.concatenate(vertices), np.concatenate(triangles)


def read_bytes(path: Path, most_bytes: int = MOST_BYTES) -> bytes:
    """Read a whole mesh file, none that is a pipe or a device: that may never end."""
    if path.suffix.lower() not in SUFFIXES:
        raise MeshFileError(
            f"a mesh file ({', '.join(SUFFIXES)})",
            f"{path}",
            "export the part as STEP, STL or 3MF",
        )
    try:
        with open_file(path) as stream:
            size = os.fstat(stream.fileno()).st_size
            data = stream.read(most_bytes) if size <= most_bytes else b""
    except NotAFileError as error:
        raise MeshFileError(
            "a mesh file",
            f"{path}, which is {error.strerror}",
            "write what comes from it to a file",
        ) from error
    except (OSError, ValueError) as error:  # the second of names that no file can have
        raise MeshFileError(
            "a readable mesh file",
            f"{str(path)!r} ({getattr(error, 'strerror', error)})",
            "check the path and its permissions",
        ) from error
    if size > most_bytes:
        raise MeshFileError(
            f"a mesh file of at most {most_bytes / 1e6:.4g} MB",
            f"{path} of {size / 1e6:.4g} MB",
            "decimate the mesh, or export single parts",
        )
    if not data:
        raise MeshFileError(
            "a mesh file with content", f"{path}, which is empty", "export it again"
        )
    return data


def stl_bytes(vertices: Array, triangles: Corners) -> bytes:
    """Binary STL of a surface: vertices (V, 3) in float32, and triangles (T, 3)."""
    from trimesh import Trimesh
    from trimesh.exchange.stl import export_stl

    return bytes(export_stl(Trimesh(vertices, triangles, process=False)))


def read_in_process(
    path: Path, data: bytes, most_bytes: int
) -> tuple[float | None, list[PlacedMesh]]:
    """Metres a unit where the file declares them, and its meshes as they are placed."""
    kind = path.suffix.lower()[1:]
    folder = ""
    if path.suffix.lower() in STEP_SUFFIXES:
        kind = "step"
        package = importlib.util.find_spec("cascadio")
        if package is None or package.origin is None:
            raise extras.missing_module("cascadio", f"needed for {path}")
        folder = str(Path(package.origin).parents[1])
    key = ""
    answer = None
    if kind == "step":
        key = _tessellation_key(data, most_bytes)
        answer = TESSELLATIONS.find(key)
    if answer is None:
        answer = _run_reader(path, data, kind, most_bytes, folder)
        if key and not answer.startswith((b'{"refused', b'{"unreadable')):
            TESSELLATIONS.keep(key, answer)
    offset = answer.index(b"\n") + 1
    head = json.loads(answer[:offset])
    if "unreadable" in head:
        raise MeshFileError(
            f"a readable {kind.upper()} file",
            f"{path} ({head['unreadable']})",
            "the file is damaged or of another format: export it again, in triangles",
        )
    if "refused" in head:
        expected, problem, remedy = head["refused"]
        raise MeshFileError(expected, f"{path} ({problem})", remedy)
    objects = []
    for coordinates, corners in head["sizes"]:
        # Views: a mesh may be hundreds of megabytes.
        points = np.frombuffer(answer, np.float64, coordinates, offset)
        offset += points.nbytes
        triangles = np.frombuffer(answer, np.int64, corners, offset)
        offset += triangles.nbytes
        objects.append((points.reshape(-1, 3), triangles.reshape(-1, 3)))
    return head["unit"], [
        (*objects[number], np.reshape([*matrix, 0.0, 0.0, 0.0, 1.0], (4, 4)))
        for number, matrix in head["placed"]
    ]


def _tessellation_key(data: bytes, most_bytes: int) -> str:
    """Digest of a STEP file, and of all that decides what comes of it."""
    digest = hashlib.sha256(f"{metadata.version('cascadio')} {most_bytes} ".encode())
    for name in ("step_files.py", "raw_meshes.py", "reading_process.py"):
        digest.update(Path(__file__).with_name(name).read_bytes())
    digest.update(data)
    return digest.hexdigest()


def _run_reader(
    path: Path, data: bytes, kind: str, most_bytes: int, folder: str
) -> bytes:
    # Neither the folder where this runs nor the user's Python settings can change what
    # is loaded.
    command = [sys.executable, "-I", "-S", "-c", _PROGRAM, _PACKAGES]
    command += [str(os.getpid()), kind, str(most_bytes), folder]
    environment = {**os.environ, "MALLOC_ARENA_MAX": "1"}
    try:
        process = subprocess.run(
            command,
            input=data,
            capture_output=True,
            timeout=_MOST_SECONDS,
            check=False,
            env=environment,
        )
    except subprocess.TimeoutExpired as error:
        raise TimedOutError(
            f"a mesh file ({kind}) that is read within {_MOST_SECONDS:g} s",
            f"{path} of {len(data) / 1e6:.3g} MB, which takes longer",
            "export single parts, or export as STL",
        ) from error
    except OSError as error:
        raise MeshFileError(
            f"a process to read {path} in",
            f"none ({reason(error)})",
            "end others that use up the memory",
        ) from error
    if process.returncode == 0 and process.stdout:
        return process.stdout
    if any(word in process.stderr for word in _OUT_OF_MEMORY):
        raise MeshFileError(
            f"a mesh file ({kind}) that is read within 1.5 GiB of memory",
            f"{path} of {len(data) / 1e6:.3g} MB, which takes more",
            "export single parts, or export as binary STL",
        )
    raise MeshFileError(
        f"a readable {kind.upper()} file",
        f"{path} of {len(data)} bytes",
        "the file is cut off, damaged or of another format: export it again",
    )
