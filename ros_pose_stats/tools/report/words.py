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

"""What pages share: numbers and warnings in words, head, style, escaping."""

import math
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template

from ...base.text import listed, several, three_digits
from ...core.records.notes import Note

SPACE = "\N{NO-BREAK SPACE}"
RANGE = "\N{EN DASH}"
UNIT = re.compile(r"(?<=\d) (?=%|mm\b)")
"""The space between a number and its unit, where a line must not end."""

WORDS = {
    "UNIT_SUSPECT": (
        "Is the unit right?",
        "Lengths, heights and times are wrong if it is not; probabilities are not "
        "touched. Most CAD systems export millimetres.",
    ),
    "UNIT_GUESSED": (
        "The unit is a guess",
        "If the guess is wrong, so are lengths, heights and times; probabilities "
        "are not touched.",
    ),
    "UNIT_OVERRIDDEN": (
        "The file declares another unit than was given",
        "Lengths, heights and times are wrong if the file is right; probabilities "
        "are not touched. Leave the unit out to take the file's own.",
    ),
    "HOLES_CLOSED": (
        "Small holes in the mesh were closed",
        "If more than flat patches is missing there, the centre of mass is off: "
        "give it, or export the mesh again.",
    ),
    "OPEN_MESH": (
        "The mesh has holes",
        "The centre of mass may be off, and so are poses on what is lost: close the "
        "mesh, or give the centre of mass.",
    ),
    "BODIES_OVERLAP": (
        "Bodies reach into each other",
        "Material counts twice, which moves the centre of mass. Unite the bodies.",
    ),
    "BODIES_APART": (
        "The file has several equal bodies",
        "One of them is the part.",
    ),
    "BODIES_LOOSE": (
        "Some bodies do not touch each other",
        "All are taken as one rigid part; what is loose in it moves in a drop.",
    ),
    "INERTIA_SUSPECT": (
        "The given inertia is too large for this part",
        "Check its unit: kg m² is meant.",
    ),
    "COM_SHIFTED": (
        "The centre of mass is shifted",
        "As the question asked: for a filling or an insert that the mesh lacks.",
    ),
    "CLUSTERED": (
        "Some poses gather many facets",
        "A curve in the mesh is made of flat facets. They are taken as one pose.",
    ),
    "MARGINAL_POSE": (
        "A pose hardly holds",
        "Do not plan a feeder on it: the slightest tilt ends it.",
    ),
    "SHALLOW_POSE": (
        "A vibrating feeder empties some poses",
        "What is given for them holds on a plate at rest only.",
    ),
    "NEAR_TIE": (
        "Two ways between poses are almost equally high",
        "The answer is still good, but parts may differ from piece to piece.",
    ),
    "ROUNDED": (
        "Round surfaces are taken as fine polygons",
        "So the answer is that of the part, however finely its file was exported.",
    ),
    "COARSE_CURVE": (
        "Shares hang on how finely a curve is divided",
        "Count on a plate what has to be known better.",
    ),
    "OUTSIDE_FIT": (
        "Nobody has measured the quick estimate on such a part or scene",
        "Trust the simulation.",
    ),
    "METHODS_DISAGREE": (
        "The quick estimates disagree",
        "Trust the simulation more than any of them.",
    ),
    "CONFLICT": (
        "Drops contradict the quick estimate",
        "The estimate is left out: the answer is that of the drops alone.",
    ),
    "MODEL_GAP": (
        "The cell counts otherwise than the model",
        "The answer has learnt from the counts; a fitted plate brings the model "
        "closer.",
    ),
    "LOW_DROP": (
        "The part is released low",
        "The pose at release will come up more often than the estimates say; the "
        "simulation knows the height.",
    ),
    "RELEASED_TOUCHING": (
        "The drop height is less than the part needs",
        "Orientations that do not fit were released touching the plate.",
    ),
    "HEIGHT_SUSPECT": ("Is the drop height right?", "It is in metres."),
    "TARGET_MISSED": (
        "The simulation ended above the wanted error",
        "Allow more drops.",
    ),
    "UNSETTLED": (
        "Some drops did not come to rest",
        "They are left out of the probabilities.",
    ),
    "WANTED_ALIKE": (
        "A wanted pose has others that look the same",
        "A camera cannot tell them apart: name them, too, unless it can.",
    ),
    "ALIKE_FROM_ABOVE": (
        "Other poses look like a wanted one from above",
        "Tell them apart by what silhouettes do not show: a height, a pocket, a mark.",
    ),
    "FORGOTTEN": ("The node does not know the part any more", "Send its mesh again."),
    "TIME_LIMIT": ("The simulation ran out of time", "What was done counts."),
    "NOT_RECORDED": ("The answer was not recorded", "Look after the disk of the log."),
}
"""By code: a heading, and what it means or what to do."""


def in_words(warning: Note) -> tuple[str, str, str]:
    """Heading, what was found, and what it means."""
    heading = warning.code.replace("_", " ").capitalize()
    heading, meaning = WORDS.get(warning.code, (heading, ""))
    return heading, begin(warning.text), meaning


def begin(sentence: str) -> str:
    """A sentence with a capital at its beginning."""
    return sentence[:1].upper() + sentence[1:]


def units(text: str) -> str:
    """Keep numbers on one line with their units."""
    return UNIT.sub(SPACE, text)


def percent(share: float) -> str:
    """A probability in percent; a dash where it is not known."""
    return "\N{EN DASH}" if math.isnan(share) else f"{100.0 * share:.1f}{SPACE}%"


def interval(low: float, high: float) -> str:
    """A 90 % interval in percent."""
    if math.isnan(low) or math.isnan(high):
        return "\N{EN DASH}"
    digits = 1 if high >= 0.01 and low <= 0.99 else 2
    return f"{100.0 * low:.{digits}f} to {100.0 * high:.{digits}f}{SPACE}%"


def millimetres(metres: float) -> str:
    """A length; words where it has no bound."""
    if not math.isfinite(metres):
        return "no other pose"
    return f"{in_millimetres(metres)}{SPACE}mm"


def in_millimetres(metres: float) -> str:
    """A length in millimetres without the unit, and never with an exponent."""
    return f"{1e3 * metres:.4g}" if metres < 10.0 else f"{1e3 * metres:.0f}"


def degrees(radians: float) -> str:
    """An angle with three digits."""
    return f"{math.degrees(radians):.3g}\N{DEGREE SIGN}"


ASSETS = Path(__file__).parent / "assets"

VIEWER_SCRIPTS = ("part_mesh", "view_direction", "view_webgl", "view_canvas", "viewer")
"""Of the view in three dimensions; each file uses functions of those before it."""


def viewer_scripts() -> str:
    """Functions that show a part, to be put into a function that hides their names."""
    return "".join((ASSETS / f"{name}.js").read_text() for name in VIEWER_SCRIPTS)


FILTERS: dict[str, Callable[..., str]] = {
    "percent": percent,
    "millimetres": millimetres,
    "units": units,
    "in_millimetres": in_millimetres,
    "degrees": degrees,
    "three_digits": three_digits,
    "listed": listed,
    "begin": begin,
    "several": several,
    "times": lambda drops: three_digits(drops) if math.isfinite(drops) else "no bound",
    "of_bar": lambda share: f"{0.0 if math.isnan(share) else 100.0 * share:.2f}",
}


@cache
def template(
    name: str, folder: Path = ASSETS, **filters: Callable[..., str]
) -> Template:
    """A page of a folder, with its own filters; all that is put in is escaped."""
    loader = FileSystemLoader([ASSETS, folder])
    environment = Environment(
        loader=loader,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    # Style or script of a file, as it is.
    environment.globals.update(
        asset=lambda file: loader.get_source(environment, file)[0],
        between=interval,
        several=several,
        viewer_scripts=viewer_scripts,
    )
    environment.filters.update(FILTERS, is_finite=math.isfinite, **filters)
    return environment.get_template(name)
