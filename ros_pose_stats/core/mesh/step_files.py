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

"""STEP files to meshes, by OpenCASCADE as cascadio has it."""

import array
import importlib.util
import json
import re
import struct
import sys
from typing import Any

from .raw_meshes import IDENTITY, RawMesh, RawScene, RefusedError, multiply

ANGLE = 0.131
"""A little over 7.5 degrees, half of which an arc spans at most: 96 sides a turn,
whatever the radius, and whole sides in every arc of a multiple of 15 degrees, so that
the halves and quarters into which CAD systems divide a circle are regular. Half of the
sides that round surfaces have in drops."""

LINEAR = 1.5e-3
"""Largest distance from the true curve, as a fraction of each edge, so that a hole has
as many sides as a rim a thousand times its size, whatever the unit. On circles the
angle decides; at 1e-3 this would divide some of them by 100."""


def read_step(data: bytes, folder: str, deflection: float = LINEAR) -> RawScene:
    """The solids of a STEP file in metres; `folder`: where cascadio is."""
    scene = read_glb(tessellate(data, folder, deflection))
    return scene._replace(unit=declared_unit(data))


def tessellate(data: bytes, folder: str, deflection: float) -> bytes:
    """A GLB file in metres of a STEP file, every circle with 96 sides.

    Of cascadio only the compiled core is loaded: its own module loads all of trimesh.
    """
    sys.path.insert(0, folder)
    package = importlib.util.find_spec("cascadio")
    assert package is not None
    sys.modules["cascadio"] = importlib.util.module_from_spec(package)
    from cascadio import _core

    # One thread, so that the order of the triangles is never a matter of chance.
    glb: bytes = _core.to_glb_bytes(
        data,
        _core.FileType.STEP,
        tol_linear=deflection,
        tol_angular=ANGLE,
        tol_relative=True,
        use_parallel=False,
    )
    return glb


_INDEX_CODES = {5121: "B", 5123: "H", 5125: "I"}
"""Types of the numbers of vertices in glTF."""

_TRIANGLES = 4
"""Mode of what glTF has as triangles; points and lines of construction have others."""

_MOST_DEPTH = 100  # of nodes in nodes


def read_glb(data: bytes) -> RawScene:
    """A GLB file as OpenCASCADE writes it."""
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    binary = memoryview(data)[28 + length :]
    meshes = [_glb_mesh(document, mesh, binary) for mesh in document.get("meshes", ())]
    placed = []
    scenes = document.get("scenes", ())
    stack = [(node, IDENTITY, 1) for scene in scenes for node in scene["nodes"]][::-1]
    while stack:
        number, above, depth = stack.pop()
        node = document["nodes"][number]
        matrix = IDENTITY
        if "matrix" in node:
            columns = node["matrix"]
            matrix = tuple(columns[4 * k + row] for row in range(3) for k in range(4))
        matrix = multiply(above, matrix)
        if "mesh" in node:
            placed.append((node["mesh"], matrix))
        if depth == _MOST_DEPTH and node.get("children"):
            raise RefusedError(
                f"at most {_MOST_DEPTH} assemblies in each other",
                "more than that",
                "export single parts",
            )
        stack += [(k, matrix, depth + 1) for k in reversed(node.get("children", ()))]
    return RawScene(meshes, placed)


def _glb_mesh(
    document: dict[str, Any], mesh: dict[str, Any], binary: memoryview
) -> RawMesh:
    joined = RawMesh()
    for primitive in mesh["primitives"]:
        if primitive.get("mode", _TRIANGLES) != _TRIANGLES:
            continue
        first = len(joined.vertices) // 3
        position = document["accessors"][primitive["attributes"]["POSITION"]]
        joined.vertices.extend(iter(_glb_numbers(document, position, binary, "f", 3)))
        index = document["accessors"][primitive["indices"]]
        code = _INDEX_CODES[index["componentType"]]
        corners = _glb_numbers(document, index, binary, code, 1)
        joined.corners.extend(first + corner for corner in corners)
    joined.check_corners()
    return joined


def _glb_numbers(
    document: dict[str, Any],
    accessor: dict[str, Any],
    binary: memoryview,
    code: str,
    size: int,
) -> "array.array[Any]":
    """Numbers without gaps, `size` an element."""
    view = document["bufferViews"][accessor["bufferView"]]
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    numbers = array.array(code)
    end = start + size * accessor["count"] * numbers.itemsize
    numbers.frombytes(binary[start:end])
    return numbers


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


def declared_unit(data: bytes) -> float:
    """Metres a unit of a STEP file's first shape; a millimetre where it names none."""
    context = _UNITS.search(data)
    if context is None:
        return 1e-3
    units: dict[bytes, bytes] = {}
    for statement in data.split(b";"):
        head, _, entity = statement.partition(b"=")
        if b"UNIT" in entity or b"MEASURE" in entity:
            units.setdefault(head.rpartition(b"#")[2].strip(), entity)
    for number in re.findall(rb"#(\d+)", context[1]):
        length = _length_unit(units, number)
        if length is not None:
            return length
    return 1e-3


def _length_unit(units: dict[bytes, bytes], number: bytes) -> float | None:
    """Metres of a unit by the number of its entity.

    None for a unit of anything else.
    """
    length = 1.0
    for _ in range(4):  # an inch is so many millimetres, a foot perhaps so many inches
        entity = units.get(number, b"")
        if metric := _SI_LENGTH.search(entity):
            return length * _SI_PREFIXES.get(metric[1].upper(), 1e-3)
        conversion = _CONVERSION.search(entity)
        if conversion is None:
            return None
        measure = _MEASURE.search(units.get(conversion[1], b""))
        if measure is None:
            return None
        try:
            length *= float(measure[1])
        except ValueError:
            return None
        number = measure[2]
    return None
