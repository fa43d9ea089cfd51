"""Mesh files: STL, OBJ, PLY, OFF, 3MF and STEP to plain arrays, and arrays to binary STL.

trimesh parses all but binary STL, which is the most common and only a table of numbers, and 3MF,
which is read in a process of its own, as cascadio tessellates STEP. This module does the rest.
Nothing is merged, reordered or repaired, so that a part's digest depends on the file alone; a file
that says less than it announces (cut off by a full disk, say) is refused; and the objects of a
scene are set in place by their transforms and joined into one mesh.
"""

import io
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import MeshFileError
from ..files import NotAFileError, read_file
from ..records import Array, Corners, Index
from . import step, units, vectors

if TYPE_CHECKING:
    from trimesh import Scene

SUFFIXES = (".stl", ".obj", ".ply", ".off", ".3mf", *step.STEP_SUFFIXES)

# The six units of the 3MF core specification.
_3MF_UNITS = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2,
              "inch": 0.0254, "foot": 0.3048, "meter": 1.0}

# Lines of an OBJ file that make trimesh cut it into pieces with a copy of all vertices each.
_OBJ_GROUPS = re.compile(rb"^[ \t]*(?:usemtl|mtllib|o|g)(?:[ \t][^\r\n]*)?$", re.MULTILINE)

_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


class FileMesh(NamedTuple):
    """The mesh of a file."""

    # (V, 3); in the file's unit, in the order of the file, not merged
    vertices: Array
    triangles: Index  # (T, 3)
    unit: float  # metres a unit
    # whether the unit was `given`, `declared` by the file, `guessed` from the size because that
    # was asked for, or `assumed` to be the metre
    unit_source: units.UnitSource = "given"
    # metres a unit as the file declares, whichever counts; None for files that declare none
    declared: float | None = None


def read_mesh(file: str | os.PathLike[str], unit: str | float | None = None, *,
              unless_declared: bool = False) -> "FileMesh":
    """Vertices and triangles of a mesh file.

    `unit`: as for `metres_per_unit`; default: what the file declares (3MF, STEP), else metres;
    `auto`: what it declares, else a guess; `unless_declared`: for a file that declares none only.
    """
    if not isinstance(file, (str, os.PathLike)):
        raise MeshFileError("the path of a mesh file", f"{type(file).__name__}",
                            "give arrays to part_from_mesh instead")
    path = Path(file)
    return parse_mesh(path, read_bytes(path), unit, unless_declared=unless_declared)


def parse_mesh(path: Path, content: bytes, unit: str | float | None = None, *,
               unless_declared: bool = False) -> "FileMesh":
    """The same of what a file holds; `path`: for the format, and for messages."""
    asked = units.asked_unit(unit)
    suffix = path.suffix.lower()
    data = _plain(path, suffix, content)
    declared = None
    if suffix == ".stl" and _is_binary_stl(data):
        vertices, triangles = _binary_triangles(data)
    elif suffix in step.STEP_SUFFIXES:
        declared = step.declared_step_unit(data)
        vertices, triangles = _tessellated(path, data, declared)
    elif suffix == ".3mf":
        unit_name, placed = step.unpack_3mf(path, data)
        declared = _3MF_UNITS.get(unit_name.strip().lower().rstrip("s"))
        vertices, triangles = _joined(placed)
    else:
        vertices, triangles = _joined(_placed(_parsed(path, suffix, data)))
    announced = _announced_faces(suffix, data)
    if len(triangles) < announced:
        raise MeshFileError(f"{announced} faces as {path} announces", f"{len(triangles)}",
                            "the file is cut off or damaged: export it again")
    if len(triangles) == 0:
        raise MeshFileError(f"triangles in {path}", "none",
                            "the file is empty, cut off, or holds only points or curves")
    metres, source = units.unit_that_counts(asked, declared, vertices, triangles, unless_declared)
    return FileMesh(vertices, triangles, metres, source, declared)


def _plain(path: Path, suffix: str, data: bytes) -> bytes:
    """Remove what the parsers cannot read: bytes behind the end, and text that is not UTF-8."""
    if suffix == ".stl" and b"\0" in data:
        count = int.from_bytes(data[80:84], "little")
        length = 84 + 50 * count
        if len(data) < 84 or len(data) < length or (len(data) > length and count == 0):
            raise MeshFileError("a readable STL file of the length that its header announces",
                                f"{path} of {len(data)} bytes where {count} triangles take "
                                f"{length}", "the file is cut off or damaged: export it again")
        return data[:length]
    if suffix in (".stl", ".obj", ".off"):
        try:
            data.decode("utf-8")
        except UnicodeDecodeError:
            # Only names and comments have other encodings, so any single-byte one will do.
            return data.decode("latin-1").encode("utf-8")
    return data


def _binary_triangles(data: bytes) -> tuple[Array, Index]:
    """Vertices and triangles of a binary STL file, three vertices a triangle."""
    records = np.frombuffer(data, _STL_TRIANGLE, offset=84)
    vertices = records["corners"].reshape(-1, 3).astype(np.float64)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


def _tessellated(path: Path, data: bytes, unit: float) -> tuple[Array, Index]:
    """Vertices, in the file's unit, and triangles of a STEP file."""
    vertices, triangles = _joined(_placed(_parsed(path, ".glb", step.tessellate_step(path, data))))
    # They came in float32, and it has to show: whoever asks for their rounding looks for it.
    return (vertices / unit).astype(np.float32).astype(np.float64), triangles


def _parsed(path: Path, suffix: str, data: bytes) -> "Scene":
    """Parse the file into a trimesh scene."""
    import trimesh  # takes as long to import as an estimate takes from start to end

    options: dict[str, Any] = {"process": False}
    if suffix == ".obj":
        data = _OBJ_GROUPS.sub(b"", data)
        options |= {"skip_materials": True, "maintain_order": True}
    elif suffix == ".ply":
        options |= {"fix_texture": False}
    try:
        return trimesh.load_scene(io.BytesIO(data), file_type=suffix[1:], **options)
    except MemoryError:
        raise
    except Exception as error:  # each of the four parsers raises errors of its own
        reason = (str(error).strip().splitlines() or [""])[0]
        found = f"{path} ({type(error).__name__}{': ' if reason else ''}{reason})"
        raise MeshFileError(f"a readable {suffix[1:].upper()} file", found,
                            "the file is damaged or of another format: export it again"
                            ) from error


def _joined(objects: Iterable[step.Placed]) -> tuple[Array, Index]:
    """Join objects, each in its place, and rewind those that are mirrored."""
    vertices: list[Array] = [np.zeros((0, 3))]
    triangles: list[Index] = [np.zeros((0, 3), dtype=np.int64)]
    offset = 0
    for points, corners, transform in objects:
        if not np.array_equal(transform, np.eye(4)):
            points = vectors.turn_vectors(points, transform[:3, :3].T) + transform[:3, 3]
            a, b, c = transform[:3, :3]
            if float((np.cross(a, b) * c).sum()) < 0.0:  # a reflection
                corners = corners[:, ::-1]
        vertices.append(points)
        triangles.append(corners + offset)
        offset += len(points)
    return np.concatenate(vertices), np.concatenate(triangles)


def _placed(scene: "Scene") -> Iterator[step.Placed]:
    """The meshes of a scene."""
    for node in scene.graph.nodes_geometry:
        mesh = scene.geometry[scene.graph[node][1]]
        corners = getattr(mesh, "faces", None)
        if corners is not None and len(corners):
            yield (np.array(mesh.vertices, dtype=np.float64), np.array(corners, dtype=np.int64),
                   _placement(scene, node))


def _placement(scene: "Scene", node: str) -> Array:
    """Matrix (4, 4) that puts a node in place; trimesh would leave its rounding to BLAS."""
    tree, placed = scene.graph.transforms, np.eye(4)
    while node != scene.graph.base_frame:
        parent = tree.parents[node]
        step = np.asarray(tree.edge_data[parent, node].get("matrix", np.eye(4)))
        placed = (step[:, :, None] * placed).sum(axis=1)
        node = parent
    return placed


def _announced_faces(suffix: str, data: bytes) -> int:
    """Count the faces that the file says it has; polygons give more triangles than that."""
    if suffix == ".stl" and not _is_binary_stl(data):
        return len(re.findall(rb"\bfacet[ \t]+normal\b", data, re.IGNORECASE))
    if suffix == ".obj":
        return len(re.findall(rb"^[ \t]*f[ \t]", data, re.MULTILINE))
    if suffix == ".ply":
        count = re.search(rb"^element[ \t]+face[ \t]+(\d+)", data, re.MULTILINE)
        return int(count[1]) if count else 0
    if suffix == ".off":
        plain = re.sub(rb"#[^\n]*", b"", data)
        count = re.search(rb"OFF\s+\d+\s+(\d+)", plain)
        return int(count[1]) if count else 0
    return 0


def _is_binary_stl(data: bytes) -> bool:
    """Whether the length fits the count in the header; `solid` may open either kind."""
    return len(data) >= 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little")


def read_bytes(path: Path) -> bytes:
    """Read a whole mesh file, none that is a pipe or a device: that may never end."""
    if path.is_dir():
        raise MeshFileError("a mesh file", f"the directory {path}", "name a file in it")
    if path.suffix.lower() not in SUFFIXES:
        raise MeshFileError(f"a mesh file ({', '.join(SUFFIXES)})", f"{path}",
                            "export the part as STEP, STL or 3MF")
    try:
        data = read_file(path)
    except NotAFileError as error:
        raise MeshFileError("a mesh file", f"{path}, which is {error.strerror}",
                            "write what comes from it to a file") from error
    except OSError as error:
        raise MeshFileError("a readable mesh file", f"{path} ({error.strerror})",
                            "check the path and its permissions") from error
    if not data:
        raise MeshFileError("a mesh file with content", f"{path}, which is empty",
                            "export it again")
    return data


def stl_bytes(vertices: Array, triangles: Corners) -> bytes:
    """Binary STL of a surface: vertices (V, 3) as they are, in float32, and triangles (T, 3)."""
    from trimesh import Trimesh
    from trimesh.exchange.stl import export_stl

    return bytes(export_stl(Trimesh(vertices, triangles, process=False)))
