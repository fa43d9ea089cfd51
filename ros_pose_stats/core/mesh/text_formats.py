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

"""STL as text, OBJ, PLY and OFF to meshes, with the standard library alone.

Nothing is merged, reordered or repaired. Faces of more than three corners are divided
from their first one on. Texture, normals and colours are passed over.
"""

import array
import io
import itertools
import re
import struct
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple, NoReturn

from .raw_meshes import RawMesh, RefusedError

AGAIN = "the file is damaged or of another format: export it again, in triangles"
CUT_OFF = "the file is cut off or damaged: export it again"

_STL_VERTEX = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)
_STL_FACET = re.compile(rb"\bfacet[ \t]+normal\b", re.IGNORECASE)
_STL_SOLID = re.compile(rb"^[ \t]*solid\b", re.IGNORECASE | re.MULTILINE)
_STL_END = re.compile(rb"^[ \t]*endsolid\b", re.IGNORECASE | re.MULTILINE)


def read_text_stl(data: bytes) -> RawMesh:
    """Every solid of the file, one after the other."""
    mesh = RawMesh()
    try:
        for match in _STL_VERTEX.finditer(data):
            mesh.vertices.extend(map(float, match.groups()))
    except ValueError:
        line_number = 1 + data.count(b"\n", 0, match.start())
        _refuse("STL", f"line {line_number}")
    triangles, rest = divmod(len(mesh.vertices), 9)
    facets = sum(1 for _ in _STL_FACET.finditer(data))
    if rest or facets != triangles:
        raise RefusedError(
            f"{facets} facets with three vertices each, as it announces",
            f"{triangles} whole ones",
            CUT_OFF,
        )
    if len(_STL_SOLID.findall(data)) > len(_STL_END.findall(data)):
        raise RefusedError(
            "an end of each solid, as it announces",
            f"{facets} facets and none",
            CUT_OFF,
        )
    mesh.corners.extend(range(3 * triangles))
    return mesh


def read_obj(data: bytes) -> RawMesh:
    """Every face, whatever its group."""
    mesh = RawMesh()
    for number, line in enumerate(_lines(data, b"\\\n"), 1):
        word, *values = line.split() or [b""]
        try:
            if word == b"v":
                _take_vertex(mesh, values)
            elif word == b"f":
                mesh.add_polygon(_obj_polygon(values, len(mesh.vertices) // 3))
        except ValueError:
            _refuse("OBJ", f"line {number}")
    mesh.check_corners()
    return mesh


def _take_vertex(mesh: RawMesh, values: list[bytes]) -> None:
    """Take x, y and z, behind which may be a weight, a colour or a normal."""
    x, y, z, *_ = values
    mesh.vertices.extend((float(x), float(y), float(z)))


def _obj_polygon(corners: list[bytes], count: int) -> list[int]:
    """Numbers of vertices from 0; negative ones count back from the face's line."""
    numbers = [int(corner.partition(b"/")[0]) for corner in corners]
    polygon = [number - 1 if number > 0 else count + number for number in numbers]
    if len(polygon) < 3 or 0 in numbers or min(polygon) < 0:
        raise ValueError
    return polygon


def read_off(data: bytes) -> RawMesh:
    """All faces; vertices may have colours and normals behind them."""
    mesh = RawMesh()
    lines = enumerate(_lines(re.sub(rb"#[^\n]*", b"", data)), 1)
    rows = ((number, values) for number, line in lines if (values := line.split()))
    _, (kind, *sizes) = next(rows, (1, [b""]))
    if not sizes:
        _, sizes = next(rows, (1, []))
    if not re.fullmatch(rb"(?:ST)?C?N?OFF", kind) or not all(map(bytes.isdigit, sizes)):
        _refuse("OFF", "no header")
    vertices, faces, *_ = *map(int, sizes), 0, 0
    for size, take in ((vertices, _take_vertex), (faces, _take_off_face)):
        for number, values in itertools.islice(rows, size):
            try:
                take(mesh, values)
            except ValueError:
                _refuse("OFF", f"line {number}")
    if len(mesh.vertices) != 3 * vertices or len(mesh.corners) < 3 * faces:
        _refuse("OFF", f"not the {vertices} vertices and {faces} faces announced")
    mesh.check_corners()
    return mesh


def _take_off_face(mesh: RawMesh, values: list[bytes]) -> None:
    size = int(values[0])
    polygon = [int(value) for value in values[1 : 1 + size]]
    if not 3 <= len(polygon) == size:
        raise ValueError
    mesh.add_polygon(polygon)


def _lines(data: bytes, continuation: bytes = b"") -> Iterator[bytes]:
    """Lines of a text, which may come from any system and go on in the next one."""
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if continuation:
        data = data.replace(continuation, b" ")
    return iter(io.BytesIO(data))


def _refuse(kind: str, problem: str) -> NoReturn:
    raise RefusedError(f"a readable {kind} file", problem, AGAIN)


PLY_TYPES = {
    "char": "b",
    "int8": "b",
    "uchar": "B",
    "uint8": "B",
    "short": "h",
    "int16": "h",
    "ushort": "H",
    "uint16": "H",
    "int": "i",
    "int32": "i",
    "uint": "I",
    "uint32": "I",
    "float": "f",
    "float32": "f",
    "double": "d",
    "float64": "d",
}
"""Names of types in a PLY header, and their codes in `struct`."""

PLY_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
POLYGONS = ("vertex_indices", "vertex_index")


class PlyProperty(NamedTuple):
    """A number, or a list of numbers."""

    name: str
    kind: str
    count_kind: str  # of the length of a list; empty for a number


class PlyElement(NamedTuple):
    """A table of the file."""

    name: str
    size: int  # rows
    properties: list[PlyProperty]

    @property
    def names(self) -> list[str]:
        """Of its properties, in their order."""
        return [entry.name for entry in self.properties]


def read_ply(data: bytes) -> RawMesh:
    """The elements `vertex` and `face`."""
    header, separator, body = data.partition(b"end_header")
    if not header.startswith(b"ply") or not separator:
        _refuse("PLY", "no header")
    mesh = RawMesh()
    try:
        order, elements = _ply_header(header)
        body = body[body.index(b"\n") + 1 :]
        table = _BinaryTable(body, order) if order else _TextTable(body)
        for element in elements:
            _take_element(mesh, element, table.rows(element))
    except (ValueError, OverflowError, KeyError, IndexError, struct.error):
        _refuse("PLY", "fewer or other values than its header announces")
    mesh.check_corners()
    return mesh


def _ply_header(header: bytes) -> tuple[str, list[PlyElement]]:
    order = "none"
    elements: list[PlyElement] = []
    for line in _lines(header):
        match line.decode("latin-1").split():
            case ["format", name, *_]:
                order = PLY_ORDERS[name]
            case ["element", name, count]:
                elements.append(PlyElement(name, int(count), []))
            case ["property", "list", count_kind, kind, name]:
                elements[-1].properties.append(
                    PlyProperty(name, PLY_TYPES[kind], PLY_TYPES[count_kind])
                )
            case ["property", kind, name]:
                elements[-1].properties.append(PlyProperty(name, PLY_TYPES[kind], ""))
    if order == "none" or any(element.size < 0 for element in elements):
        raise ValueError
    return order, elements


Row = tuple[Any, ...]
"""By property: a number, or the numbers of a list."""


def _take_element(mesh: RawMesh, element: PlyElement, rows: Iterable[Row]) -> None:
    """Put the rows of an element into a mesh."""
    names = element.names
    polygons = [name for name in names if name in POLYGONS]
    if element.name == "vertex":
        x, y, z = map(names.index, "xyz")
        for row in rows:
            mesh.vertices.extend((row[x], row[y], row[z]))
    elif element.name == "face" and polygons:
        column = names.index(polygons[0])
        for row in rows:
            if len(row[column]) < 3:
                raise ValueError
            mesh.add_polygon([int(value) for value in row[column]])
    else:
        for _ in rows:  # what follows is behind them
            pass


class _TextTable:
    """Rows of elements, one behind the other, in words."""

    def __init__(self, body: bytes) -> None:
        self._words = iter(body.split())

    def rows(self, element: PlyElement) -> Iterator[Row]:
        """The next rows."""
        if not element.properties:
            return
        for _ in range(element.size):
            row: list[Any] = []
            for entry in element.properties:
                if entry.count_kind:
                    (length,) = self._numbers(1, entry.count_kind)
                    row.append(self._numbers(length, entry.kind))
                else:
                    row += self._numbers(1, entry.kind)
            yield tuple(row)

    def _numbers(self, count: int, kind: str) -> "array.array[Any]":
        """Numbers as their type can hold them: `float` has fewer digits than words."""
        words = itertools.islice(self._words, count)
        numbers = array.array(kind, map(float if kind in "fd" else int, words))
        if len(numbers) < count:
            raise ValueError
        return numbers


class _BinaryTable:
    """The same in bytes."""

    def __init__(self, body: bytes, order: str) -> None:
        self._body = body
        self._order = order
        self._offset = 0

    def rows(self, element: PlyElement) -> Iterator[Row]:
        """The next rows; tables of numbers, and of triangles alone, are quicker."""
        count = element.size
        properties = element.properties
        if not properties or count == 0:
            return
        if not any(entry.count_kind for entry in properties):
            yield from self._equal_rows(
                "".join(entry.kind for entry in properties), count
            )
            return
        _, kind, count_kind = properties[0]
        size = struct.calcsize(f"{self._order}{count_kind}3{kind}")
        counts = self._body[self._offset : self._offset + size * count : size]
        is_triangles = len(counts) == count and counts.count(3) == count
        if len(properties) == 1 and count_kind in "bB" and is_triangles:
            for _, *corners in self._equal_rows(f"{count_kind}3{kind}", count):
                yield (corners,)
            return
        for _ in range(count):
            row: list[Any] = []
            for entry in properties:
                if entry.count_kind:
                    (length,) = self._take(entry.count_kind)
                    row.append(self._take(f"{length}{entry.kind}"))
                else:
                    row += self._take(entry.kind)
            yield tuple(row)

    def _equal_rows(self, code: str, count: int) -> Iterator[Row]:
        layout = struct.Struct(self._order + code)
        block = self._body[self._offset : self._offset + layout.size * count]
        self._offset += layout.size * count
        if len(block) < layout.size * count:
            raise ValueError
        return layout.iter_unpack(block)

    def _take(self, code: str) -> Row:
        layout = struct.Struct(self._order + code)
        values = layout.unpack_from(self._body, self._offset)
        self._offset += layout.size
        return values
