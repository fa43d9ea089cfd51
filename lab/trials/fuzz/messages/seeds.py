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

"""Messages and requests as clients send them, and with hostile values in their
fields.
"""

from array import array
from importlib import import_module
from random import Random

import numpy as np
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh, MeshTriangle

HOSTILE_NAMES = (
    "",
    ".",
    "..",
    "../../x",
    "../" * 40 + "etc/x",
    "/etc/x",
    "/tmp/x",
    "~/x",
    "..\\x",
    "C:\\x",
    "a\0b",
    "a\nb",
    "\x1b[31mred",
    "\r\nFATAL",
    "\u202egnp.exe",
    "\u200b",
    "\ufeff",
    "x" * 201,
    "y" * 5000,
    "%s%n%x",
    "$(touch x)",
    "`touch x`",
    "; touch x",
    "part/1",
    "*",
    "🗿",
    "a b",
    "{}",
    "{0}",
    "'",
    '"',
    "nul",
    "-rf",
    "part.mcap",
    ".lock",
    "metadata.yaml",
)
HOSTILE_NUMBERS = (
    float("nan"),
    float("inf"),
    -float("inf"),
    0.0,
    -0.0,
    5e-324,
    -5e-324,
    1e-300,
    1e-30,
    1e30,
    1e160,
    1.7976931348623157e308,
    -1.7976931348623157e308,
    -1.0,
    1.0,
    0.5,
    1.0 - 2**-53,
)
HOSTILE_COUNTS = (0, 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)
SECONDS = (0, 1_700_000_000, -(2**31), 2**31 - 1)
METHODS = ("", "combined", "csae", "simulation", "nothing", *HOSTILE_NAMES)

GOOD = {
    "restitution": -1.0,
    "drop_height": -1.0,
    "unit": 1.0,
    "target_error": 0.0,
    "max_seconds": 0.0,
    "cluster_tolerance": 0.0025,
    "w": 0.8,
    "m": 0.1,
    "ixx": 1e-5,
    "iyy": 1e-5,
    "izz": 1e-5,
    "drops": 20,
    "round_sides": 192,
    "numbering": 0,
    "index": 0,
    "from_pose": -1,
    "body": -1,
}
"""Values that the node takes, by the name of the field."""

CORNERS = np.array(
    [(0.0, 0.0, 0.0), (0.04, 0.0, 0.0), (0.0, 0.03, 0.0), (0.01, 0.01, 0.02)]
)
FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
HOSTILE = 0.3
"""Share of fields that get a hostile value."""


class Seeds:
    """Makes messages of which most fields are good."""

    def __init__(self, chance: Random) -> None:
        self.chance = chance

    def make(self, kind):
        """A message, request or goal."""
        if kind is Mesh:
            return self._mesh()
        message = kind()
        for name, field_type in kind.get_fields_and_field_types().items():
            if field_type.startswith("sequence<"):
                inner = field_type[9:].rpartition(">")[0]
                count = self.chance.choice((2, 2, 2, self.chance.randrange(5)))
                setattr(message, name, [self._value(name, inner) for _ in range(count)])
            elif name != "structure_needs_at_least_one_member":
                setattr(message, name, self._value(name, field_type))
        if kind is PartMesh:
            self._fill(message)
        return message

    def _odd(self):
        return self.chance.random() < HOSTILE

    def _value(self, name, kind):
        """A value of a field by its type; nested messages are made, half of the parts
        left out.
        """
        if kind == "string" or kind.startswith("string<"):
            if name == "method":
                return self.chance.choice(METHODS)
            odd = self.chance.choice(HOSTILE_NAMES) if self._odd() else ""
            return odd or f"part_{self.chance.randrange(8)}"
        if kind == "double":
            good = GOOD.get(name, 0.01)
            return self.chance.choice(HOSTILE_NUMBERS) if self._odd() else float(good)
        if kind == "boolean":
            return self.chance.random() < 0.5
        if name == "sec":
            return self.chance.choice(SECONDS)
        if kind.startswith(("uint", "int")):
            bits = int(kind.lstrip("uint")) - kind.startswith("int")
            return (
                self.chance.choice(HOSTILE_COUNTS) % 2**bits
                if self._odd()
                else GOOD.get(name, 3)
            )
        package, _, short = kind.partition("/")
        message_type = getattr(import_module(f"{package}.msg"), short)
        left_out = (short == "Inertia" and not self._odd()) or (
            short == "PartMesh" and self.chance.random() < 0.3
        )
        return message_type() if left_out else self.make(message_type)

    def _surface(self):
        """A tetrahedron of a size of its own, sometimes spoiled."""
        vertices = CORNERS * self.chance.uniform(0.5, 2.0)
        triangles = FACES.copy()
        cell = self.chance.randrange(4), self.chance.randrange(3)
        if self._odd():
            if self.chance.random() < 0.5:
                vertices[cell] = self.chance.choice(HOSTILE_NUMBERS)
            else:
                triangles[cell] = self.chance.choice(HOSTILE_COUNTS) % 2**32
        return vertices, triangles.astype(np.uint32)

    def _mesh(self):
        message, (vertices, triangles) = Mesh(), self._surface()
        point = import_module("geometry_msgs.msg").Point
        message.vertices = [point(x=x, y=y, z=z) for x, y, z in vertices.tolist()]
        message.triangles = [MeshTriangle(vertex_indices=row) for row in triangles]
        return message

    def _fill(self, part):
        """Flat, nested, both or neither."""
        form = self.chance.choice(
            ("flat", "flat", "flat", "nested", "nested", "both", "none")
        )
        part.mesh = self._mesh() if form in ("nested", "both") else Mesh()
        vertices, triangles = (
            self._surface() if form in ("flat", "both") else (CORNERS[:0],) * 2
        )
        part.vertices = array("d", vertices.tobytes())
        part.triangles = array("I", triangles.astype(np.uint32).tobytes())
