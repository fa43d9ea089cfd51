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

"""Draws docs/figures/architecture.svg from the imports of the package.

    python -m tests.house.architecture_picture

Each wing stands on what is below it, and each room in a wing on the rooms that its
arrows reach. What lies on the next floor has an arrow; lower floors may be imported as
well.
"""

import ast
import textwrap
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from tests.house.imports import Sources
from tests.house.test_layering import FLOORS, PACKAGE
from tests.house.weight import ROOT

PICTURE = ROOT / "docs" / "figures" / "architecture.svg"

WIDTH = 1000
MARGIN = 12
FLOOR_GAP = 26
TITLE_HEIGHT = 44
LINE_HEIGHT = 13
CHARACTER = 6.3
"""Pixels of a character of the small print, on average."""

COLOURS = {"tools": "#e8f1e4", "node": "#fdeede", "core": "#e4edf8", "base": "#eeeeee"}


class Box(NamedTuple):
    """A rectangle in pixels, from its upper left corner."""

    x: float
    y: float
    width: float
    height: float


def sentence(package, *rooms):
    """The first sentence of the docstring of a room."""
    text = Path(package, *rooms, "__init__.py").read_text(encoding="utf-8")
    return (ast.get_docstring(ast.parse(text)) or "").partition("\n")[0].rstrip(".")


def rooms_by_floor(wing):
    """Folders of a wing, the highest floor first."""
    floors = [
        sorted(room for room in floor if (PACKAGE / wing / room).is_dir())
        for floor in FLOORS.get(wing, ())
    ]
    return [floor for floor in reversed(floors) if floor]


def imports_between(sources, folder, floors):
    """Pairs of rooms in a folder of which one imports the other, a floor below it."""
    prefix = f"{PACKAGE.name}.{folder}." if folder else f"{PACKAGE.name}."
    neighbours = {
        (importer, target)
        for upper, lower in pairwise(floors)
        for importer in upper
        for target in lower
    }
    imported = {
        (
            arrow.importer.removeprefix(prefix).partition(".")[0],
            arrow.target.removeprefix(prefix).partition(".")[0],
        )
        for arrow in sources.internal
        if arrow.importer.startswith(prefix) and arrow.target.startswith(prefix)
    }
    return sorted(neighbours & imported)


def small_print(text, width):
    """Lines of a sentence in a box of some pixels."""
    return textwrap.wrap(text, int((width - 16) / CHARACTER))


def room_width(wing_width, rooms):
    """Pixels of each of some rooms side by side."""
    return (wing_width - MARGIN * (rooms + 1)) / rooms


def floor_height(wing, floor, wing_width):
    """Pixels of the rooms of a floor, of which all sentences can be read."""
    width = room_width(wing_width, len(floor))
    lines = max(
        len(small_print(sentence(PACKAGE, wing, room), width)) for room in floor
    )
    return 26 + LINE_HEIGHT * lines


def words_in(box, title, text):
    """A title and small print below it, in a rectangle."""
    x = box.x + 8
    lines = [f'<text x="{x:.0f}" y="{box.y + 18:.0f}" class="title">{title}</text>']
    for row, line in enumerate(small_print(text, box.width)):
        y = box.y + 33 + LINE_HEIGHT * row
        lines.append(
            f'<text x="{x:.0f}" y="{y:.0f}" class="small">{escape(line)}</text>'
        )
    return lines


def rectangle(box, colour):
    """A filled rectangle with round corners."""
    return (
        f'<rect x="{box.x:.0f}" y="{box.y:.0f}" width="{box.width:.0f}" '
        f'height="{box.height:.0f}" rx="6" fill="{colour}" stroke="#888888"/>'
    )


def arrow_between(upper, lower):
    """A line with a head, from the lower side of a box to the upper side of another
    one.
    """
    x1 = upper.x + upper.width / 2
    x2 = min(max(x1, lower.x + 20), lower.x + lower.width - 20)
    y1 = upper.y + upper.height
    y2 = lower.y - 2
    middle = (y1 + y2) / 2
    return (
        f'<path d="M{x1:.0f},{y1:.0f} C{x1:.0f},{middle:.0f} {x2:.0f},{middle:.0f} '
        f'{x2:.0f},{y2:.0f}" class="arrow" marker-end="url(#head)"/>'
    )


def wing_height(wing, width):
    """Pixels of a wing with its floors."""
    heights = [floor_height(wing, floor, width) for floor in rooms_by_floor(wing)]
    return TITLE_HEIGHT + sum(heights) + FLOOR_GAP * (len(heights) - 1) + MARGIN


def draw_wing(sources, wing, box):
    """A wing with its rooms and the arrows between them."""
    lines = [rectangle(box, COLOURS[wing])]
    lines += words_in(box, wing, sentence(PACKAGE, wing))
    boxes = {}
    y = box.y + TITLE_HEIGHT
    floors = rooms_by_floor(wing)
    for floor in floors:
        width = room_width(box.width, len(floor))
        height = floor_height(wing, floor, box.width)
        for column, room in enumerate(floor):
            x = box.x + MARGIN + column * (width + MARGIN)
            boxes[room] = Box(x, y, width, height)
        y += height + FLOOR_GAP

    for importer, target in imports_between(sources, wing, floors):
        lines.append(arrow_between(boxes[importer], boxes[target]))
    for room, room_box in boxes.items():
        lines.append(rectangle(room_box, "#ffffff"))
        lines += words_in(room_box, room, sentence(PACKAGE, wing, room))
    return lines


def wing_boxes():
    """Tools and node side by side, the core below them, and the base below all."""
    half = (WIDTH - 3 * MARGIN) / 2
    whole = WIDTH - 2 * MARGIN
    top = max(wing_height("tools", half), wing_height("node", half))
    core_y = MARGIN + top + 2 * FLOOR_GAP
    base_y = core_y + wing_height("core", whole) + 2 * FLOOR_GAP
    return {
        "tools": Box(MARGIN, MARGIN, half, top),
        "node": Box(2 * MARGIN + half, MARGIN, half, top),
        "core": Box(MARGIN, core_y, whole, wing_height("core", whole)),
        "base": Box(MARGIN, base_y, whole, TITLE_HEIGHT),
    }


def draw(sources):
    """The whole picture as text of an SVG file."""
    wings = wing_boxes()
    height = wings["base"].y + wings["base"].height + MARGIN
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:.0f}" '
        'font-family="sans-serif">',
        "<style>.title{font-size:14px;font-weight:bold}"
        ".small{font-size:11px;fill:#444444}"
        ".arrow{fill:none;stroke:#777777;stroke-width:1.3}</style>",
        '<defs><marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0,0 L8,4 L0,8 z" fill="#777777"/>'
        "</marker></defs>",
        f'<rect width="{WIDTH}" height="{height:.0f}" fill="#ffffff"/>',
    ]
    floors = [["tools", "node"], ["core"], ["base"]]
    for importer, target in imports_between(sources, "", floors):
        lines.append(arrow_between(wings[importer], wings[target]))
    for wing, box in wings.items():
        lines += draw_wing(sources, wing, box)
    node = wings["node"]
    middle = node.y + node.height / 2
    lines.append(
        f'<path d="M{node.x - MARGIN:.0f},{middle:.0f} h{MARGIN - 2}" '
        'class="arrow" marker-end="url(#head)"/>'
    )
    return "\n".join([*lines, "</svg>", ""])


def main():
    """Write the picture."""
    PICTURE.write_text(draw(Sources(PACKAGE)), encoding="utf-8")


if __name__ == "__main__":
    main()
