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

"""Units of mesh files: their names, which one counts, and doubts about it."""

import math
from collections.abc import Iterable

import numpy as np

from ...base import errors, text
from ..records import Array, Corners
from ..records.notes import Note, note
from . import arrays

AUTO = "auto"  # the unit that asks for what the file names, else for the rule

METRES_PER_UNIT = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254}

_SPELLINGS = {
    "metre": "m",
    "meter": "m",
    "millimetre": "mm",
    "millimeter": "mm",
    "centimetre": "cm",
    "centimeter": "cm",
    "in": "inch",
    "inche": "inch",
}
"""In lower case and without the plural's s."""

_LONGEST_IN_METRES = 0.6
"""Extent, in its own unit, up to which a file that names none is in metres, else in
millimetres: parts in millimetres are longer than that, and parts in metres shorter."""

_USUAL = (0.2e-3, 2.0)  # lengths of parts for feeders, metres

_SAME = 1e-6  # relative difference up to which two units are one


def unit_name(text: str) -> str | None:
    """`m`, `mm`, `cm` or `inch` from any usual spelling of it in any case.

    None for others.
    """
    name = text.strip().lower()
    if name in METRES_PER_UNIT:
        return name
    return _SPELLINGS.get(name.removesuffix("s"))


def metres_per_unit(unit: str | float) -> float:
    """Metres of `m`, `mm`, `cm` or `inch` in any usual spelling, or of a number."""
    if isinstance(unit, str) and (name := unit_name(unit)) is not None:
        return METRES_PER_UNIT[name]
    length = math.nan if isinstance(unit, (str, bool)) else arrays.number_or_nan(unit)
    if not 0.0 < length < math.inf:
        raise errors.RequestError(
            "a mesh unit of m, mm, cm, inch or a positive number of metres",
            f"{unit!r}",
            "most CAD systems export millimetres: 'mm'",
        )
    return length


def requested_unit(unit: str | float | None) -> float | None:
    """Metres a unit as a user asks for it; None for what the file says."""
    if unit is None or (isinstance(unit, str) and unit.strip().lower() == AUTO):
        return None
    return metres_per_unit(unit)


def guess_unit(extent: float) -> float:
    """Metres a unit of a mesh whose file names none, by its extent in that unit."""
    # Binary STL and `float` of PLY round 0.6 up.
    is_in_metres = extent <= _LONGEST_IN_METRES * (1.0 + _SAME)
    return 1.0 if is_in_metres else 1e-3


def extent_of(vertices: Array, triangles: Corners) -> float:
    """Largest extent of a mesh along an axis; NaN for one that is none."""
    corners = triangles.ravel()
    if not len(corners) or corners.min() < 0 or corners.max() >= len(vertices):
        return math.nan
    points = arrays.remove_unused(vertices, triangles)[0]
    if not np.isfinite(points).all():
        return math.nan
    with np.errstate(over="ignore"):
        return arrays.extent_of(points)


def missing_unit(
    name: str, vertices: Array, triangles: Corners, remedy: str
) -> errors.RequestError:
    """Refusal of a file that names no unit, where a guess would be acted on."""
    extent = extent_of(vertices, triangles)
    return errors.RequestError(
        f"the unit of {name}, which names none: its length is "
        + _lengths(extent, ("mm", "inch", "m")),
        "none",
        remedy,
    )


def unit_warnings(
    extent: float, unit: float, is_guessed: bool, declared: float | None
) -> tuple[Note, ...]:
    """Warn about a guessed unit, one the file contradicts, or an unlikely size.

    `extent`: in metres; `unit`: metres of the one that counts; `declared`: of the one
    that the file names.
    """
    size = text.length_in_words(extent)
    name = unit_in_words(unit)
    other_lengths = _lengths(
        extent / unit, [other for other in METRES_PER_UNIT if other != name]
    )
    warnings = []
    if is_guessed:
        warnings.append(
            note(
                "UNIT_GUESSED",
                f"the file names no unit; it was taken to be in {name}, {size} long "
                f"(else {other_lengths}). Give the unit to be sure: --unit {name}.",
            )
        )
    if declared is not None and not math.isclose(unit, declared, rel_tol=_SAME):
        warnings.append(
            note(
                "UNIT_OVERRIDDEN",
                f"the file's own unit is {unit_in_words(declared)}, but it was taken "
                f"to be in {name}, as asked: all lengths are {unit / declared:.4g} "
                "times those that the file names.",
            )
        )
    shortest, longest = _USUAL
    if not shortest <= extent <= longest:
        warnings.append(
            note(
                "UNIT_SUSPECT",
                f"the part is {size} long, unusual for a fed part; check the unit "
                f"({other_lengths}).",
            )
        )
    return tuple(warnings)


def unit_in_words(metres: float) -> str:
    """The name of a unit, or its length where it has none."""
    for name, length in METRES_PER_UNIT.items():
        if math.isclose(metres, length, rel_tol=_SAME):
            return name
    return f"units of {metres:.4g} m"


def _lengths(extent: float, names: Iterable[str]) -> str:
    """What so many units are long in each of some units: `80 mm in mm, 80 m in m`."""
    return ", ".join(
        f"{text.length_in_words(extent * METRES_PER_UNIT[name])} in {name}"
        for name in names
    )
