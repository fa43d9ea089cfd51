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

"""Files that catalogues are made of here, and how their tables are read."""

import csv

from lab.bodies import shapes
from tests.answers import write_stl

TABLES = "catalogue.csv", "poses.csv"
REFUSED = {
    "letter.stl": b"Dear colleague,",
    "empty.step": b"",
    "flat.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "none.stl": b"solid\nendsolid\n",
    "bare.step": b"ISO-10303-21;\nEND-ISO-10303-21;\n",
    **dict.fromkeys(
        (
            "a\rb.stl",
            "c\nd.stl",
            'g"h,i;j\tk.stl',
            " l .stl",
            "ü\x85\u2028.stl",
            "\x1b[31mred.stl",
        ),
        bytes(84),  # a binary file without triangles
    ),
}
ROCKS = 30
PARTS = len(REFUSED) + ROCKS + 5
ASKED = (
    "catalogue",
    "parts",
    "\ufeff =1+1.stl",
    "parts/box.stl",
    "--unit",
    "cm",
    "--restitution",
    0.2,
    "--drop-height",
    0.4,
    "--density",
    7850.0,
    "--workers",
    1,
)


def set_parts(parts, late):
    """Put the parts there that are changed, removed and new, as they are early or
    late.
    """
    old = parts / "a_removed.stl"
    new = parts / "a_new.stl"
    write_stl(
        parts / "a_changed.stl",
        shapes.box(*((3.0, 3.5, 4.0) if late else (1.0, 2.0, 3.0))),
    )
    write_stl(new if late else old, shapes.box(4.0, 3.0, 1.0))
    (old if late else new).unlink(missing_ok=True)


def tables(folder):
    return [(folder / name).read_bytes() for name in TABLES]


def rows_of(folder, name="catalogue.csv"):
    with (folder / name).open(
        newline="", encoding="utf-8", errors="surrogateescape"
    ) as lines:
        return list(csv.DictReader(lines))
