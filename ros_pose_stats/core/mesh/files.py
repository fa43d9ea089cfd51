"""Mesh files: STL, OBJ, PLY, OFF, 3MF and STEP to arrays, and arrays to STL.

trimesh parses all but binary STL, which is the most common and only a table of numbers,
and 3MF, which is read in a process of its own, as cascadio tessellates STEP. This
module does the rest. Nothing is merged, reordered or repaired, so that a part's digest
depends on the file alone; a file that says less than it announces (cut off by a full
disk, say) is refused; and the objects of a scene are set in place by their transforms
and joined into one mesh.
"""

import importlib.util
import io
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...base import extras
from ...base.errors import MeshFileError
from ...base.files import NotAFileError, read_file
from ..records import Array, Corners, Index
from . import units, vectors

if TYPE_CHECKING:
    from trimesh import Scene

PlacedMesh = tuple[Array, Index, Array]
"""Vertices (V, 3) and triangles (T, 3) of an object, and the matrix (4, 4) that places
it."""

STEP_SUFFIXES = (".step", ".stp")

_MOST_SECONDS = 120.0
"""A part of ten thousand faces takes some seconds; what takes longer is a whole
machine."""

_READER = Path(__file__).with_name("reading_process.py")

_SI_PREFIXES = {
    b"$": 1.0,
    b".KILO.": 1e3,
    b".HECTO.": 1e2,
    b".DECA.": 1e1,
    b".DECI.": 1e-1,
    b".CENTI.": 1e-2,
    b".MILLI.": 1e-3,
    b".MICRO.": 1e-6,
    b".NANO.": 1e-9,
}
_UNITS = re.compile(rb"GLOBAL_UNIT_ASSIGNED_CONTEXT\s*\(\s*\(([^)]*)\)")
_SI_LENGTH = re.compile(rb"SI_UNIT\s*\(\s*([^,\s]+)\s*,\s*\.METRE\.")
_CONVERSION = re.compile(rb"CONVERSION_BASED_UNIT\s*\(\s*'[^']*'\s*,\s*#(\d+)")
_MEASURE = re.compile(rb"LENGTH_MEASURE\s*\(\s*([-+.\dEe]+)\s*\)\s*,\s*#(\d+)")

SUFFIXES = (".stl", ".obj", ".ply", ".off", ".3mf", *STEP_SUFFIXES)

# The six units of the 3MF core specification.
_3MF_UNITS = {
    "micron": 1e-6,
    "millimeter": 1e-3,
    "centimeter": 1e-2,
    "inch": 0.0254,
    "foot": 0.3048,
    "meter": 1.0,
}

# Lines of an OBJ file that make trimesh cut it into pieces with a copy of all vertices
# each.
_OBJ_GROUPS = re.compile(
    rb"^[ \t]*(?:usemtl|mtllib|o|g)(?:[ \t][^\r\n]*)?$", re.MULTILINE
)

# A face that counts its vertices back, which trimesh does from the end of the file.
_OBJ_BACKWARDS = re.compile(rb"^[ \t]*f[ \t][^\r\n]*-", re.MULTILINE)

_STL_TRIANGLE = np.dtype(
    [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
)


class FileMesh(NamedTuple):
    """The mesh of a file."""

    # (V, 3) array_like; in the file's unit, in the order of the file, not merged
    vertices: Any
    triangles: Any  # (T, 3) array_like of int
    unit: float  # metres a unit
    # whether the unit was `given`, `declared` by the file, `guessed` from the size
    # because that was asked for, or `assumed` to be the metre
    unit_source: units.UnitSource = "given"
    # metres a unit as the file declares, whichever counts; None for files that declare
    # none
    declared: float | None = None


def read_mesh(
    file: str | os.PathLike[str],
    unit: str | float | None = None,
    *,
    unless_declared: bool = False,
) -> "FileMesh":
    """Vertices and triangles of a mesh file.

    `unit` and `unless_declared` as for `load_part`.
    """
    if not isinstance(file, (str, os.PathLike)):
        raise MeshFileError(
            "the path of a mesh file",
            f"{type(file).__name__}",
            "give arrays to part_from_mesh instead",
        )
    path = Path(file)
    return parse_mesh(path, read_bytes(path), unit, unless_declared=unless_declared)


def parse_mesh(
    path: Path,
    content: bytes,
    unit: str | float | None = None,
    *,
    unless_declared: bool = False,
) -> "FileMesh":
    """The same of what a file holds; `path`: for the format, and for messages."""
    requested = units.requested_unit(unit)
    suffix = path.suffix.lower()
    data = _clean_bytes(path, suffix, content)
    declared = None
    if suffix == ".stl" and _is_binary_stl(data):
        corners = np.frombuffer(data, _STL_TRIANGLE, offset=84)["corners"]
        vertices: Array = corners.reshape(-1, 3).astype(np.float64)
        triangles: Index = np.arange(len(vertices)).reshape(-1, 3)
    elif suffix in STEP_SUFFIXES:
        declared = declared_step_unit(data)
        metres, triangles = _join_meshes(
            _parse_objects(path, ".glb", tessellate_step(path, data))
        )
        # They came in float32, and it has to show: whoever asks for their rounding
        # looks for it.
        vertices = (metres / declared).astype(np.float32).astype(np.float64)
    elif suffix == ".3mf":
        unit_name, objects = unpack_3mf(path, data)
        declared = _3MF_UNITS.get(unit_name.strip().lower().rstrip("s"))
        vertices, triangles = _join_meshes(objects)
    else:
        vertices, triangles = _join_meshes(_parse_objects(path, suffix, data))
    announced = _count_announced_faces(suffix, data)
    if len(triangles) < announced:
        raise MeshFileError(
            f"{announced} faces as {path} announces",
            f"{len(triangles)}",
            "the file is cut off or damaged: export it again",
        )
    if len(triangles) == 0:
        raise MeshFileError(
            f"triangles in {path}",
            "none",
            "the file is empty, cut off, or holds only points or curves",
        )
    metres_a_unit, source = units.choose_unit(
        requested, declared, vertices, triangles, unless_declared
    )
    return FileMesh(vertices, triangles, metres_a_unit, source, declared)


def _clean_bytes(path: Path, suffix: str, data: bytes) -> bytes:
    """Remove bytes behind the end and text that is not UTF-8, for the parsers."""
    if suffix == ".stl" and b"\0" in data:
        count = int.from_bytes(data[80:84], "little")
        length = 84 + 50 * count
        if len(data) < length or (len(data) > length and count == 0):
            raise MeshFileError(
                "a readable STL file of the length that its header announces",
                f"{path} of {len(data)} bytes where {count} triangles take {length}",
                "the file is cut off or damaged: export it again",
            )
        return data[:length]
    if suffix in (".stl", ".obj", ".off"):
        try:
            data.decode("utf-8")
        except UnicodeDecodeError:
            # Only names and comments have other encodings, so any single-byte one will
            # do.
            return data.decode("latin-1").encode("utf-8")
    return data


def _parse_objects(path: Path, suffix: str, data: bytes) -> list[PlacedMesh]:
    """Parse the file into its objects."""
    import trimesh  # takes as long to import as an estimate takes from start to end

    options: dict[str, Any] = {"process": False}
    if suffix == ".obj":
        data = _OBJ_GROUPS.sub(b"", data)
        options |= {"skip_materials": True, "maintain_order": True}
    elif suffix == ".ply":
        options |= {"fix_texture": False}
    try:
        if suffix == ".obj" and _OBJ_BACKWARDS.search(data):
            data = _number_forwards(data)
        return list(
            _placed_meshes(
                trimesh.load_scene(io.BytesIO(data), file_type=suffix[1:], **options)
            )
        )
    except MemoryError:
        raise
    except Exception as error:  # each of the four parsers raises errors of its own
        problem = type(error).__name__
        if str(error).strip():
            problem += f": {str(error).strip().splitlines()[0]}"
        raise MeshFileError(
            f"a readable {suffix[1:].upper()} file",
            f"{path} ({problem})",
            "the file is damaged or of another format: export it again, in triangles",
        ) from error


def _number_forwards(data: bytes) -> bytes:
    """An OBJ file whose faces number vertices from the first on, not backwards."""
    vertices = 0
    lines = []
    for line in data.splitlines():
        word, *corners = line.split() or [b""]
        vertices += word == b"v"
        if word == b"f":
            numbers = [int(corner.partition(b"/")[0]) for corner in corners]
            numbers = [
                number if number > 0 else vertices + 1 + number for number in numbers
            ]
            if min(numbers, default=1) < 1:
                raise ValueError("a face before its vertices")
            line = b"f " + b" ".join(b"%d" % number for number in numbers)
        lines.append(line)
    return b"\n".join(lines)


def _join_meshes(objects: Iterable[PlacedMesh]) -> tuple[Array, Index]:
    """Join objects, each in its place, and rewind those that are mirrored."""
    vertices: list[Array] = [np.zeros((0, 3))]
    triangles: list[Index] = [np.zeros((0, 3), dtype=np.int64)]
    offset = 0
    for points, corners, transform in objects:
        if not np.array_equal(transform, np.eye(4)):
            points = (
                vectors.turn_vectors(points, transform[:3, :3].T) + transform[:3, 3]
            )
            a, b, c = transform[:3, :3]
            if float((np.cross(a, b) * c).sum()) < 0.0:  # a reflection
                corners = corners[:, ::-1]
        vertices.append(points)
        triangles.append(corners + offset)
        offset += len(points)
    return np.concatenate(vertices), np.concatenate(triangles)


def _placed_meshes(scene: "Scene") -> Iterator[PlacedMesh]:
    """The meshes of a scene."""
    for node in scene.graph.nodes_geometry:
        mesh = scene.geometry[scene.graph[node][1]]
        corners = getattr(mesh, "faces", None)
        if corners is not None and len(corners):
            yield (
                np.array(mesh.vertices, dtype=np.float64).reshape(
                    len(mesh.vertices), 3
                ),
                np.array(corners, dtype=np.int64),
                _placement(scene, node),
            )


def _placement(scene: "Scene", node: str) -> Array:
    """Matrix (4, 4) that puts a node in place.

    Trimesh would leave its rounding to BLAS.
    """
    tree = scene.graph.transforms
    matrix = np.eye(4)
    while node != scene.graph.base_frame:
        parent = tree.parents[node]
        step = np.asarray(tree.edge_data[parent, node].get("matrix", np.eye(4)))
        matrix = (step[:, :, None] * matrix).sum(axis=1)
        node = parent
    return matrix


def _count_announced_faces(suffix: str, data: bytes) -> int:
    """Count the faces that the file says it has.

    Polygons give more triangles than that.
    """
    if suffix == ".stl" and not _is_binary_stl(data):
        return len(re.findall(rb"\bfacet[ \t]+normal\b", data, re.IGNORECASE))
    if suffix == ".obj":
        return len(re.findall(rb"^[ \t]*f[ \t]", data, re.MULTILINE))
    count = None
    if suffix == ".ply":
        count = re.search(rb"^element[ \t]+face[ \t]+(\d+)", data, re.MULTILINE)
    elif suffix == ".off":
        count = re.search(rb"OFF\s+\d+\s+(\d+)", re.sub(rb"#[^\n]*", b"", data))
    return int(count[1]) if count else 0


def _is_binary_stl(data: bytes) -> bool:
    """Whether the length fits the count in the header; `solid` may open either kind."""
    return len(data) == 84 + 50 * int.from_bytes(data[80:84], "little")


def read_bytes(path: Path) -> bytes:
    """Read a whole mesh file, none that is a pipe or a device: that may never end."""
    if path.suffix.lower() not in SUFFIXES:
        raise MeshFileError(
            f"a mesh file ({', '.join(SUFFIXES)})",
            f"{path}",
            "export the part as STEP, STL or 3MF",
        )
    try:
        data = read_file(path)
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


def tessellate_step(path: Path, data: bytes) -> bytes:
    """GLB file in metres of a STEP file, every circle with 96 sides."""
    package = importlib.util.find_spec("cascadio")
    if package is None or package.origin is None:
        raise extras.missing_module("cascadio", f"needed for {path}")
    return _run_reader(path, data, "STEP", str(Path(package.origin).parents[1]))


def unpack_3mf(path: Path, data: bytes) -> tuple[str, list[PlacedMesh]]:
    """Unit of a 3MF file, and its objects, each as often as it is built."""
    line, _, arrays = _run_reader(path, data, "3MF", "").partition(b"\n")
    head = json.loads(line)
    if "unreadable" in head:
        raise MeshFileError(
            "a readable 3MF file",
            f"{path} ({head['unreadable']})",
            "the file is damaged or of another format: export it again",
        )
    if "refused" in head:
        expected, problem, remedy = head["refused"]
        raise MeshFileError(
            f"a 3MF file with {expected}", f"{path} ({problem})", remedy
        )
    objects = []
    offset = 0
    for coordinates, corners in head["sizes"]:
        split = offset + 8 * coordinates
        end = offset + 8 * (coordinates + corners)
        objects.append(
            (
                np.frombuffer(arrays[offset:split], np.float64).reshape(-1, 3),
                np.frombuffer(arrays[split:end], np.int64).reshape(-1, 3),
            )
        )
        offset = end
    return head["unit"], [
        (*objects[number], np.reshape([*matrix, 0.0, 0.0, 0.0, 1.0], (4, 4)))
        for number, matrix in head["placed"]
    ]


def _run_reader(path: Path, data: bytes, kind: str, folder: str) -> bytes:
    # Neither the folder where this runs nor the user's Python settings can change what
    # is loaded.
    command = [sys.executable, "-I", "-S", str(_READER), str(os.getpid()), folder]
    try:
        process = subprocess.run(
            command, input=data, capture_output=True, timeout=_MOST_SECONDS, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise MeshFileError(
            f"a {kind} file that is read within {_MOST_SECONDS:g} s",
            f"{path} of {len(data) / 1e6:.3g} MB, which takes longer",
            "export single parts, or export as STL",
        ) from error
    if process.returncode != 0 or not process.stdout:
        raise MeshFileError(
            f"a readable {kind} file",
            f"{path} of {len(data)} bytes",
            "the file is cut off, damaged or of another format: export it again",
        )
    return process.stdout


def declared_step_unit(data: bytes) -> float:
    """Metres a unit of a STEP file's first shape; a millimetre where it names none."""
    context = _UNITS.search(data)
    for number in re.findall(rb"#(\d+)", context[1]) if context else ():
        length = _length_unit(data, number)
        if length is not None:
            return length
    return 1e-3


def _length_unit(data: bytes, number: bytes) -> float | None:
    """Metres of a unit by the number of its entity.

    None for a unit of anything else.
    """
    length = 1.0
    for _ in range(4):  # an inch is so many millimetres, a foot perhaps so many inches
        entity = _entity(data, number)
        if metric := _SI_LENGTH.search(entity):
            return length * _SI_PREFIXES.get(metric[1].upper(), 1e-3)
        conversion = _CONVERSION.search(entity)
        measure = _MEASURE.search(_entity(data, conversion[1])) if conversion else None
        if measure is None:
            return None
        try:
            length *= float(measure[1])
        except ValueError:
            return None
        number = measure[2]
    return None


def _entity(data: bytes, number: bytes) -> bytes:
    """What stands behind `#number =`."""
    match = re.search(rb"#" + number + rb"\s*=([^;]*);", data)
    return match[1] if match else b""
