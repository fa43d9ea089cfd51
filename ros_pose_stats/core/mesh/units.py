"""Units of mesh files: their names, which one counts, and doubts about it."""

import math
from typing import Literal

import numpy as np

from ...base import errors, text
from ..records import Array, Corners
from .arrays import number_or_nan

AUTO: Literal["auto"] = "auto"  # the unit that asks for a guess
UnitSource = Literal["given", "declared", "guessed", "assumed"]

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

_PRIOR = {"mm": 0.62, "m": 0.25, "inch": 0.1, "cm": 0.03}
"""How often files are in a unit: CAD systems export millimetres, ROS means metres."""

_USUAL = 40.0
_POSSIBLE = (0.5, 1000.0)
"""Lengths of parts on feeders, millimetres: of the median one, and of nearly all. Two
thirds lie between a quarter of the median and four times as much."""

_GRIDS = (
    (100.0, 0.1),
    (50.0, 0.05),
    (10.0, 0.15),
    (5.0, 0.1),
    (1.0, 0.25),
    (0.5, 0.1),
    (0.1, 0.1),
    (12.7, 0.03),
    (3.175, 0.04),
    (1.5875, 0.03),
    (2.54, 0.03),
    (0.254, 0.03),
)
"""Steps in which people draw, millimetres and fractions of an inch, and how often."""

_OFF_GRID = 1e-5  # how likely any other length is, beside one of a step's multiples
_MOST_LENGTHS = 12  # lengths that count; more of them hang together
_UNDOUBTED = (0.2e-3, 2.0)
_UNDOUBTED_ASSUMED = (0.5e-3, 1.0)
"""Lengths of parts in metres. Where nobody named the unit a part of a metre and a half
is more likely to be one of a centimetre and a half or an inch and a half."""

_SAME = 1e-6  # relative difference up to which two units are one


def unit_name(text: str) -> str | None:
    """`m`, `mm`, `cm` or `inch` from any usual spelling of it in any case.

    None for others.
    """
    name = text.strip().lower()
    if name in METRES_PER_UNIT:
        return name
    return _SPELLINGS.get(name.removesuffix("s"))


def rank_units(vertices: Array, triangles: Corners) -> list[str]:
    """Units that make a mesh a part for a feeder, the most likely one first.

    Likely are a usual size, and lengths from the near end to flat faces across an axis
    in few steps of a grid that people draw on: 5, 2.5 and 1.375 are in inches rather
    than in millimetres.
    """
    lengths, rounding = _lengths(vertices, triangles)
    grid_steps, shares = np.array(_GRIDS).T
    evidence = {}
    for unit, prior in _PRIOR.items():
        scale = 1e3 * METRES_PER_UNIT[unit]
        size = float(lengths.max(initial=0.0)) * scale
        if _POSSIBLE[0] <= size <= _POSSIBLE[1]:
            steps = lengths[:, None] * scale / grid_steps
            round_ones = (
                np.abs(steps - np.round(steps)) <= steps * rounding / lengths[:, None]
            )
            likelihood = _OFF_GRID + (round_ones * shares / steps).sum(axis=1)
            evidence[unit] = (
                math.log(prior)
                - 0.5 * math.log(size / _USUAL, 4.0) ** 2
                + np.log(likelihood).mean() * min(len(likelihood), _MOST_LENGTHS)
            )
    return sorted(evidence, key=lambda unit: -evidence[unit])


def _lengths(vertices: Array, triangles: Corners) -> tuple[Array, float]:
    """Distinct lengths of a mesh along its axes, and by how much they may be off."""
    corner = vertices[triangles]
    low = corner.min(axis=(0, 1))
    high = corner.max(axis=(0, 1))
    rounding = 4e-6 * float((high - low).max())
    if not 0.0 < rounding < math.inf:
        return np.zeros(0), 0.0
    is_flat = np.ptp(corner, axis=1) <= rounding
    lengths = np.sort(np.concatenate(((corner[:, 0] - low)[is_flat], high - low)))
    lengths = lengths[lengths > rounding]
    return lengths[np.diff(lengths, prepend=0.0) > rounding], rounding


def metres_per_unit(unit: str | float) -> float:
    """Metres of `m`, `mm`, `cm` or `inch` in any usual spelling, or of a number."""
    if isinstance(unit, str) and (name := unit_name(unit)) is not None:
        return METRES_PER_UNIT[name]
    length = math.nan if isinstance(unit, (str, bool)) else number_or_nan(unit)
    if not 0.0 < length < math.inf:
        raise errors.RequestError(
            "a mesh unit of m, mm, cm, inch or a positive number of metres",
            f"{unit!r}",
            "most CAD systems export millimetres: 'mm'",
        )
    return length


def requested_unit(unit: str | float | None) -> float | Literal["auto"] | None:
    """What a user asks for: metres a unit, a guess for `auto`, or nothing."""
    if isinstance(unit, str) and unit.strip().lower() == AUTO:
        return AUTO
    return None if unit is None else metres_per_unit(unit)


def choose_unit(
    requested: float | Literal["auto"] | None,
    declared: float | None,
    vertices: Array,
    triangles: Corners,
    unless_declared: bool,
) -> tuple[float, UnitSource]:
    """Metres a unit of a file, and where that comes from."""
    if declared is not None and (unless_declared or requested in (None, AUTO)):
        return declared, "declared"
    if requested != AUTO:
        return (1.0, "assumed") if requested is None else (float(requested), "given")
    corners = triangles.ravel()
    if not len(corners) or corners.min() < 0 or corners.max() >= len(vertices):
        return 1.0, "assumed"  # refused where the part is built
    extent = float(np.ptp(vertices[corners], axis=0).max())
    if not math.isfinite(extent):
        return 1.0, "assumed"  # refused with its vertex there
    candidates = rank_units(vertices, triangles)
    if not candidates:
        raise errors.RequestError(
            "a mesh that in mm, m, inch or cm is 0.5 mm to 1 m long",
            f"one {extent:.3g} units long",
            "give its unit",
        )
    return METRES_PER_UNIT[candidates[0]], "guessed"


def unit_warnings(
    extent: float,
    metres: Array,
    triangles: Corners,
    unit: float,
    source: UnitSource,
    declared: float | None,
) -> tuple[str, ...]:
    """Warn about an unlikely size, a guessed unit, or one the file contradicts."""
    size = text.length_in_words(extent)
    shortest, longest = _UNDOUBTED_ASSUMED if source == "assumed" else _UNDOUBTED
    is_usual = shortest <= extent <= longest
    alternatives = (
        []
        if is_usual and source != "guessed"
        else [
            f"{name}: {text.length_in_words(extent / unit * METRES_PER_UNIT[name])}"
            for name in rank_units(metres / unit, triangles)
            if METRES_PER_UNIT[name] != unit
        ]
    )
    if source == "guessed":
        hint = f" (else in {', '.join(alternatives)})" if alternatives else ""
        name = _unit_in_words(unit)
        return (
            f"UNIT_GUESSED: the file names no unit; it was taken to be in {name}, "
            f"{size} long{hint}. Give the unit to be sure: --unit {name}.",
        )
    warnings = []
    if declared is not None and not math.isclose(unit, declared, rel_tol=_SAME):
        warnings.append(
            f"UNIT_OVERRIDDEN: the file's own unit is {_unit_in_words(declared)}, but "
            f"it was taken to be in {_unit_in_words(unit)}, as asked: all lengths are "
            f"{unit / declared:.4g} times those that the file names."
        )
    if not is_usual:
        reason = (
            "since its file names no unit and metres are assumed"
            if source == "assumed"
            else "unusual for a fed part"
        )
        suggestion = f"; likely in {alternatives[0]}" if alternatives else ""
        warnings.append(
            f"UNIT_SUSPECT: the part is {size} long, {reason}{suggestion}; check the "
            "unit."
        )
    return tuple(warnings)


def _unit_in_words(metres: float) -> str:
    for name, length in METRES_PER_UNIT.items():
        if math.isclose(metres, length, rel_tol=_SAME):
            return name
    return f"units of {metres:.4g} m"
