"""Units of mesh files: their names, which one counts, and doubts about it."""

import math
from typing import Literal

from .. import errors, text
from .arrays import NOT_NUMBERS, real_number

AUTO: Literal["auto"] = "auto"
"""The unit that asks for a guess."""

UnitSource = Literal["given", "declared", "guessed", "assumed"]

METRES_PER_UNIT = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254}

_SPELLINGS = {"metre": "m", "meter": "m", "millimetre": "mm", "millimeter": "mm",
              "centimetre": "cm", "centimeter": "cm", "in": "inch", "inche": "inch"}
"""In lower case and without the plural's s."""

_GUESSES = ("mm", "m", "inch", "cm")
"""Units to guess, in the order in which they are met: CAD systems export millimetres, ROS means
metres."""

_USUAL = (2e-3, 0.5)
_POSSIBLE = (0.5e-3, 1.0)
"""Lengths of parts on feeders in metres, of most and of nearly all."""

_UNDOUBTED = (0.2e-3, 2.0)
_UNDOUBTED_ASSUMED = (0.5e-3, 1.0)
"""Lengths of parts in metres. Where nobody named the unit a part of a metre and a half is more
likely to be one of a centimetre and a half or an inch and a half."""

_SAME = 1e-6
"""Relative difference up to which two units are one."""


def named_unit(text: str) -> str | None:
    """`m`, `mm`, `cm` or `inch` from any usual spelling of it in any case; None for others."""
    name = text.strip().lower()
    if name in METRES_PER_UNIT:
        return name
    return _SPELLINGS.get(name.removesuffix("s"))


def likely_unit(extent: float) -> str | None:
    """The unit in which a mesh most likely is.

    `extent`: its largest extent in that unit. Returns none where no unit makes it a part for a
    feeder.
    """
    for shortest, longest in (_USUAL, _POSSIBLE):
        for unit in _GUESSES:
            if shortest <= extent * METRES_PER_UNIT[unit] <= longest:
                return unit
    return None


def guess_unit(extent: float) -> str:
    """As `likely_unit`.

    Raises RequestError where no unit makes it a part for a feeder.
    """
    unit = likely_unit(extent)
    if unit is None:
        raise errors.RequestError("a mesh that in mm, m, inch or cm is 0.5 mm to 1 m long",
                                  f"one {extent:.3g} units long", "give its unit")
    return unit


def metres_per_unit(unit: str | float) -> float:
    """Length of one mesh unit in metres.

    `unit`: `m`, `mm`, `cm` or `inch` in any usual spelling (`MM`, `inches`, `millimetres`), or a
    positive number of metres. Raises RequestError if it is neither.
    """
    if isinstance(unit, str) and (name := named_unit(unit)) is not None:
        return METRES_PER_UNIT[name]
    try:
        length = math.nan if isinstance(unit, (str, bool)) else real_number(unit)
    except NOT_NUMBERS:
        length = math.nan
    if not 0.0 < length < math.inf:
        raise errors.RequestError("a mesh unit of m, mm, cm, inch or a positive number of metres",
                                  f"{unit!r}", "most CAD systems export millimetres: 'mm'")
    return length


def asked_unit(unit: str | float | None) -> float | Literal["auto"] | None:
    """What a user asks for: metres a unit, a guess, or nothing.

    `unit`: as for `metres_per_unit`, or `auto`. Raises RequestError if it is neither.
    """
    if isinstance(unit, str) and unit.strip().lower() == AUTO:
        return AUTO
    return None if unit is None else metres_per_unit(unit)


def unit_that_counts(asked: float | Literal["auto"] | None, declared: float | None,
                     extent: float, unless_declared: bool) -> tuple[float, UnitSource]:
    """Metres a unit of a file, and where that comes from.

    `extent`: of its mesh in its own unit, for a guess; `unless_declared`: whether `asked` is for
    files that declare no unit only. Raises RequestError as `guess_unit`.
    """
    if declared is not None and (unless_declared or asked in (None, AUTO)):
        return declared, "declared"
    if asked == AUTO:
        return metres_per_unit(guess_unit(extent)), "guessed"
    return (1.0, "assumed") if asked is None else (float(asked), "given")


def unit_warnings(extent: float, unit: float, source: UnitSource,
                  declared: float | None) -> tuple[str, ...]:
    """Warn about a part of an unlikely size, a guessed unit, and one that the file contradicts.

    `extent`: largest extent of the part, metres; `declared`: metres a unit as the file declares.
    """
    size, likely = text.length_in_words(extent), likely_unit(extent / unit)
    if source == "guessed":
        return (f"UNIT_GUESSED: the file names no unit; as its mesh is {extent / unit:.3g} units "
                f"long, it was taken to be in {likely}, {size} long. Give the unit to be sure.",)
    return (*_overridden(unit, declared), *_suspect(extent, unit, source, likely))


def _overridden(unit: float, declared: float | None) -> tuple[str, ...]:
    if declared is None or math.isclose(unit, declared, rel_tol=_SAME):
        return ()
    return (f"UNIT_OVERRIDDEN: the file's own unit is {_unit_in_words(declared)}, but it was "
            f"taken to be in {_unit_in_words(unit)}, as asked: all lengths are "
            f"{unit / declared:.4g} times those that the file names.",)


def _suspect(extent: float, unit: float, source: UnitSource,
             likely: str | None) -> tuple[str, ...]:
    shortest, longest = _UNDOUBTED_ASSUMED if source == "assumed" else _UNDOUBTED
    if shortest <= extent <= longest:
        return ()
    size = text.length_in_words(extent)
    why = ("since its file names no unit and metres are assumed" if source == "assumed"
           else "unusual for a fed part")
    if likely is None or METRES_PER_UNIT[likely] == unit:
        return (f"UNIT_SUSPECT: the part is {size} long, {why}; check the unit.",)
    meant = text.length_in_words(extent / unit * METRES_PER_UNIT[likely])
    return (f"UNIT_SUSPECT: the part is {size} long, {why}; in {likely} it would be {meant} "
            "long: check the unit.",)


def _unit_in_words(metres: float) -> str:
    for name, length in METRES_PER_UNIT.items():
        if math.isclose(metres, length, rel_tol=_SAME):
            return name
    return f"units of {metres:.4g} m"
