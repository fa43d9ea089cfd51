"""A program of its own that reads STEP or 3MF files from standard input.

On some damaged files OpenCASCADE ends the whole process, and it prints as it likes; a
small 3MF file can stand for more than any memory holds. Here that harms nobody. Of
`cascadio` only the compiled core is loaded, since its own module loads all of trimesh
and takes ten times as long; 3MF is read with the standard library alone.
"""

import array
import ctypes
import importlib.util
import io
import json
import os
import signal
import sys
import zipfile
from collections.abc import Callable
from xml.parsers import expat

ANGLE = 0.131
"""A little over 7.5 degrees, half of which an arc spans at most: 96 sides a turn,
whatever the radius, and whole sides in every arc of a multiple of 15 degrees, so that
the halves and quarters into which CAD systems divide a circle are regular. Half of the
sides that round surfaces have in drops."""

LINEAR = 1.5e-3
"""Largest distance from the true curve, as a fraction of each edge, so that a hole has
as many sides as a rim a thousand times its size, whatever the unit. On circles the
angle decides; at 1e-3 this would divide some of them by 100."""

PR_SET_PDEATHSIG = 1  # of Linux's `prctl`

MOST_EXPANDED = 2**29
"""Bytes of a 3MF file once it is decompressed: some ten million triangles."""

MOST_INSTANCES = 100_000
MOST_DEPTH = 100
"""Of the objects in a 3MF file, and of components in components."""

MOST_TRIANGLES = 10_000_000
MOST_VERTICES = 30_000_000
"""Of a 3MF file, with every object as often as it is placed."""

NO_MODEL = ("support", "solidsupport", "other")
"""Types of the objects in a 3MF file that a printer makes or shows beside the part."""

ROOT_TYPE = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
"""Type of the relationship that names the model of a 3MF file which has the build."""

IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
"""Three rows of a matrix that leaves everything in its place."""


def main(parent: int, folder: str) -> None:
    """Read standard input for a parent.

    `folder`: where cascadio is, for STEP; empty for 3MF.
    """
    die_with(parent)
    answer = os.dup(1)
    os.dup2(2, 1)
    convert = tessellate if folder else unpack
    with os.fdopen(answer, "wb") as output:
        for piece in convert(sys.stdin.buffer.read(), folder):
            output.write(piece)


def tessellate(data: bytes, folder: str) -> list[bytes]:
    """A GLB file of a STEP file."""
    sys.path.insert(0, folder)
    package = importlib.util.find_spec("cascadio")
    assert package is not None
    sys.modules["cascadio"] = importlib.util.module_from_spec(package)
    from cascadio import _core

    # One thread, so that the order of the triangles is never a matter of chance.
    return [
        _core.to_glb_bytes(
            data,
            _core.FileType.STEP,
            tol_linear=LINEAR,
            tol_angular=ANGLE,
            tol_relative=True,
            use_parallel=False,
        )
    ]


def unpack(data: bytes, _: str) -> list[bytes]:
    """JSON about a 3MF file in a line, then coordinates and corners of its objects."""
    try:
        archive = Archive(data)
        instances = archive.instances()
    except RefusedError as refusal:
        return [json.dumps({"refused": refusal.args}).encode()]
    except Exception as error:  # whatever else is wrong with the file
        return [json.dumps({"unreadable": f"{type(error).__name__}: {error}"}).encode()]
    keys = list(dict.fromkeys(key for key, _ in instances))
    objects = [archive.objects[key] for key in keys]
    number = {key: position for position, key in enumerate(keys)}
    head = {
        "unit": archive.unit,
        "sizes": [(len(mesh.vertices), len(mesh.corners)) for mesh in objects],
        "placed": [(number[key], matrix) for key, matrix in instances],
    }
    return [
        json.dumps(head).encode() + b"\n",
        *(
            numbers.tobytes()
            for mesh in objects
            for numbers in (mesh.vertices, mesh.corners)
        ),
    ]


Reference = tuple[tuple[str, str], tuple[float, ...]]
"""An object, by its model and its id, and the rows of the matrix that places it."""


class RefusedError(Exception):
    """What was expected, what came, and what to do."""


class Object:
    """An object of a 3MF file: its own mesh, and other objects in it."""

    def __init__(self) -> None:
        self.vertices = array.array("d")
        self.corners = array.array("q")
        self.components: list[Reference] = []
        self.is_model = True


class Archive:
    """A 3MF file: a zip file of models, one of which says what is built."""

    def __init__(self, data: bytes) -> None:
        self._zip = zipfile.ZipFile(io.BytesIO(data))
        self._names = {name.strip("/").lower(): name for name in self._zip.namelist()}
        self._expanded = 0
        self._models: set[str] = set()
        self.objects: dict[tuple[str, str], Object] = {}
        self.items: list[Reference] = []
        self.unit = "millimeter"  # of a file that names none
        self.root = self._root()
        self._read(self.root)

    def instances(self) -> list[Reference]:
        """Objects with a mesh, as often as they are built, and their matrices."""
        instances = []
        triangles = 0
        vertices = 0
        visits = 0
        built = [item for item in self.items if self._object(item[0]).is_model]
        if not built:
            raise RefusedError(
                "a model in its build",
                "only objects that are none, as supports are"
                if self.items
                else "an empty build",
                "place the part on the build plate, and export it again",
            )
        stack = [(key, matrix, 1) for key, matrix in order_like_trimesh(built)]
        while stack:
            key, matrix, depth = stack.pop()
            mesh = self._object(key)
            visits += 1
            if not mesh.is_model:
                continue
            triangles += len(mesh.corners) // 3
            vertices += len(mesh.vertices) // 3
            placed = visits + len(stack) + len(mesh.components)
            check_limit(placed, MOST_INSTANCES, "placed objects")
            check_limit(depth, MOST_DEPTH, "objects in each other")
            check_limit(triangles, MOST_TRIANGLES, "triangles")
            check_limit(vertices, MOST_VERTICES, "vertices")
            if mesh.corners:
                instances.append((key, matrix))
            stack += [
                (component, multiply(matrix, component_matrix), depth + 1)
                for component, component_matrix in order_like_trimesh(mesh.components)
            ]
        return instances

    def _object(self, key: tuple[str, str]) -> Object:
        if key not in self.objects and key[0] not in self._models:
            self._read(key[0])
        if key not in self.objects:
            raise RefusedError(
                "every object that is built to be in it",
                f"none with id {key[1]!r}",
                "export it again",
            )
        return self.objects[key]

    def _root(self) -> str:
        """The model that the file's relationships name; else the usual one."""
        roots = []

        def start(tag: str, fields: dict[str, str]) -> None:
            is_relationship = tag.rpartition(":")[2] == "Relationship"
            if is_relationship and fields.get("Type") == ROOT_TYPE:
                roots.append(fields["Target"].strip("/").lower())

        if "_rels/.rels" in self._names:
            self._parse("_rels/.rels", start)
        roots += [name for name in self._names if "3d/3dmodel.model" in name]
        for root in roots:
            if root in self._names:
                return root
        raise RefusedError("a model in it", "none", "export it again")

    def _read(self, model: str) -> None:
        """Read one model of the file."""
        self._models.add(model)
        current = Object()

        def start(tag: str, fields: dict[str, str]) -> None:
            nonlocal current
            match tag.rpartition(":")[2]:
                case "vertex":
                    current.vertices.extend(
                        (float(fields["x"]), float(fields["y"]), float(fields["z"]))
                    )
                case "triangle":
                    current.corners.extend(
                        (int(fields["v1"]), int(fields["v2"]), int(fields["v3"]))
                    )
                case "object":
                    current = self.objects[model, fields["id"]] = Object()
                    current.is_model = fields.get("type") not in NO_MODEL
                case "component":
                    current.components.append(reference(fields))
                case "item" if model == self.root:
                    self.items.append(reference(fields))
                case "model" if model == self.root:
                    self.unit = fields.get("unit", self.unit)

        def reference(fields: dict[str, str]) -> Reference:
            path = model
            for name, value in fields.items():
                if name.rpartition(":")[2] == "path":
                    path = value
                    break
            return (path.strip("/").lower(), fields["objectid"]), placement(fields)

        self._parse(model, start)
        for mesh in self.objects.values():
            count = len(mesh.vertices) // 3
            if mesh.corners and not 0 <= min(mesh.corners) <= max(mesh.corners) < count:
                raise RefusedError(
                    "triangles between vertices of their object",
                    "others",
                    "export it again",
                )

    def _parse(self, name: str, start: Callable[[str, dict[str, str]], None]) -> None:
        """Call `start` with each element of an XML file in the archive."""

        def refuse(*_: object) -> None:
            raise RefusedError("no entities of its own", "some", "export it again")

        parser = expat.ParserCreate()
        parser.StartElementHandler = start
        parser.EntityDeclHandler = refuse
        with self._zip.open(self._names[name]) as stream:
            while piece := stream.read(2**20):
                self._expanded += len(piece)
                if self._expanded > MOST_EXPANDED:
                    raise RefusedError(
                        f"at most {MOST_EXPANDED} bytes once it is decompressed",
                        "more than that",
                        "export single parts, or as STL",
                    )
                parser.Parse(piece, False)
        parser.Parse(b"", True)


def check_limit(number: int, limit: int, noun: str) -> None:
    """Refuse a file that has more of something than would be sensible."""
    if number > limit:
        raise RefusedError(
            f"at most {limit} {noun}",
            "more than that",
            "export single parts, or join the objects before",
        )


def order_like_trimesh(placed: list[Reference]) -> list[Reference]:
    """References in trimesh's order, which makes the digest.

    The first object, then the others from the last one on, instances together.

    So trimesh has it, and the order makes the digest.
    """
    by_object: dict[tuple[str, str], list[Reference]] = {}
    for reference in placed:
        by_object.setdefault(reference[0], []).append(reference)
    references = [reference for group in by_object.values() for reference in group]
    return [*references[1:], *references[:1]]


def placement(fields: dict[str, str]) -> tuple[float, ...]:
    """The rows of the matrix of an element, which the file has column by column."""
    if "transform" not in fields:
        return IDENTITY
    values = [float(number) for number in fields["transform"].split()]
    if len(values) != 12:
        raise RefusedError(
            "transforms of twelve numbers", f"{len(values)}", "export it again"
        )
    return tuple(values[3 * column + row] for row in range(3) for column in range(4))


def multiply(first: tuple[float, ...], second: tuple[float, ...]) -> tuple[float, ...]:
    """The matrix that does the second, then the first."""
    if first is IDENTITY or second is IDENTITY:
        return second if first is IDENTITY else first
    return tuple(
        sum(first[4 * row + k] * second[4 * k + column] for k in range(3))
        + (first[4 * row + 3] if column == 3 else 0.0)
        for row in range(3)
        for column in range(4)
    )


def die_with(parent: int) -> None:
    """Have this process end when its parent does, even by `kill -9`.

    A file may take minutes.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it was quicker
        os._exit(1)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
