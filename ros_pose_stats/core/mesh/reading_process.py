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

"""A program of its own that reads mesh files from standard input.

On some damaged files OpenCASCADE ends the whole process, and it prints as it likes; a
small file can stand for more than any memory holds, or take hours. Here that harms
nobody: memory is bounded, and whoever started it ends it in time. All but STEP is read
with the standard library alone, since NumPy and trimesh take longer to load than most
files to read.
"""

import ctypes
import io
import json
import os
import resource
import signal
import sys
import zipfile
from collections.abc import Callable, Mapping
from typing import BinaryIO
from xml.parsers import expat

from . import step_files, text_formats
from .raw_meshes import (
    IDENTITY,
    RawMesh,
    RawScene,
    RefusedError,
    Rows,
    multiply,
    scene_of,
)

MOST_MEMORY = 3 * 2**29
"""Bytes of addresses: 1.5 GiB."""

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

_TEXT_READERS = {
    "stl": text_formats.read_text_stl,
    "obj": text_formats.read_obj,
    "ply": text_formats.read_ply,
    "off": text_formats.read_off,
}


def main(parent: int, kind: str, most_bytes: int, folder: str) -> None:
    """Read standard input for a parent.

    `kind`: suffix of the file; `most_bytes`: of the arrays of all that is placed;
    `folder`: where cascadio is, for STEP.
    """
    die_with(parent)
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    answer = os.dup(1)
    os.dup2(2, 1)  # whatever prints must not come between the answer
    with os.fdopen(answer, "wb") as output:
        try:
            scene = read_scene(kind, sys.stdin.buffer.read(), folder)
            check_size(scene, most_bytes)
        except RefusedError as refusal:
            write_head(output, {"refused": refusal.args})
        except MemoryError:
            raise
        except Exception as error:  # its words may be those of the file
            write_head(output, {"unreadable": type(error).__name__})
        else:
            write_scene(output, scene)


def read_scene(kind: str, data: bytes, folder: str) -> RawScene:
    """The meshes of a file."""
    if kind == "step":
        return step_files.read_step(data, folder)
    if kind == "3mf":
        try:
            return read_3mf(data)
        except RefusedError as refusal:
            expected, problem, remedy = refusal.args
            raise RefusedError(f"a 3MF file with {expected}", problem, remedy) from None
    return scene_of(_TEXT_READERS[kind](data))


def check_size(scene: RawScene, most_bytes: int) -> None:
    """Refuse what would fill the memory of whoever asked."""
    sizes = [8 * (len(mesh.vertices) + len(mesh.corners)) for mesh in scene.meshes]
    if sum(sizes[number] for number, _ in scene.placed) > most_bytes:
        raise RefusedError(
            f"a mesh of at most {most_bytes / 1e6:.4g} MB in memory",
            "a larger one",
            "decimate it, or export single parts",
        )


def write_head(output: BinaryIO, head: Mapping[str, object]) -> None:
    """Write the first line of the answer, in JSON."""
    output.write(json.dumps(head).encode() + b"\n")


def write_scene(output: BinaryIO, scene: RawScene) -> None:
    """Write what is in the file, then coordinates and corners of each mesh."""
    head = {
        "unit": scene.unit,
        "sizes": [(len(mesh.vertices), len(mesh.corners)) for mesh in scene.meshes],
        "placed": scene.placed,
    }
    write_head(output, head)
    for mesh in scene.meshes:
        output.write(mesh.vertices)
        output.write(mesh.corners)


METRES_3MF = {
    "micron": 1e-6,
    "millimeter": 1e-3,
    "centimeter": 1e-2,
    "inch": 0.0254,
    "foot": 0.3048,
    "meter": 1.0,
}
"""The six units of the 3MF core specification."""


def read_3mf(data: bytes) -> RawScene:
    """What a 3MF file builds: its objects, each as often as it is placed."""
    archive = Archive(data)
    instances = archive.instances()
    keys = list(dict.fromkeys(key for key, _ in instances))
    number = {key: position for position, key in enumerate(keys)}
    return RawScene(
        [archive.objects[key] for key in keys],
        [(number[key], matrix) for key, matrix in instances],
        METRES_3MF.get(archive.unit.strip().lower().rstrip("s")),
    )


Reference = tuple[tuple[str, str], Rows]
"""An object, by its model and its id, and the rows of the matrix that places it."""


class Object(RawMesh):
    """An object of a 3MF file: its own mesh, and other objects in it."""

    def __init__(self) -> None:
        super().__init__()
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
                "one that is not",
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
            mesh.check_corners()

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
    """
    by_object: dict[tuple[str, str], list[Reference]] = {}
    for reference in placed:
        by_object.setdefault(reference[0], []).append(reference)
    references = [reference for group in by_object.values() for reference in group]
    return [*references[1:], *references[:1]]


def placement(fields: dict[str, str]) -> Rows:
    """The rows of the matrix of an element, which the file has column by column."""
    if "transform" not in fields:
        return IDENTITY
    values = [float(number) for number in fields["transform"].split()]
    if len(values) != 12:
        raise RefusedError(
            "transforms of twelve numbers", f"{len(values)}", "export it again"
        )
    return tuple(values[3 * column + row] for row in range(3) for column in range(4))


def die_with(parent: int) -> None:
    """Have this process end when its parent does, even by `kill -9`.

    A file may take minutes.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it was quicker
        os._exit(1)
