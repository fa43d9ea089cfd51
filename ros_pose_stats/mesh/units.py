"""Units of mesh files."""

from __future__ import annotations

import math
from typing import Final

from ..errors import RequestError
from .arrays import NOT_NUMBERS, real_number

METRES_PER_UNIT: Final = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254}

_SPELLINGS: Final = {"metre": "m", "meter": "m", "millimetre": "mm", "millimeter": "mm",
                     "centimetre": "cm", "centimeter": "cm", "in": "inch", "inche": "inch"}
"""In lower case and without the plural's s."""

_GUESSES: Final = ("mm", "m", "inch", "cm")
"""Units to guess, in the order in which they are met: CAD systems export millimetres, ROS means
metres."""

_USUAL: Final = (2e-3, 0.5)
_POSSIBLE: Final = (0.5e-3, 1.0)
"""Lengths of parts on feeders in metres, of most and of nearly all."""


def named_unit(text: str) -> str | None:
    """`m`, `mm`, `cm` or `inch` from any usual spelling of it in any case; None for others."""
    name = text.strip().lower()
    if name in METRES_PER_UNIT:
        return name
    return _SPELLINGS.get(name.removesuffix("s"))


def likely_unit(extent: float) -> str | None:
    """The unit in which a mesh most likely is.

    Parameters
    ----------
    extent : float
        Its largest extent in that unit.

    Returns
    -------
    str or None
        None where no unit makes it a part for a feeder.
    """
    for shortest, longest in (_USUAL, _POSSIBLE):
        for unit in _GUESSES:
            if shortest <= extent * METRES_PER_UNIT[unit] <= longest:
                return unit
    return None


def guess_unit(extent: float) -> str:
    """As `likely_unit`.

    Raises
    ------
    RequestError
        Where no unit makes it a part for a feeder.
    """
    unit = likely_unit(extent)
    if unit is None:
        raise RequestError("a mesh that in mm, m, inch or cm is 0.5 mm to 1 m long",
                           f"one {extent:.3g} units long", "give its unit")
    return unit


def metres_per_unit(unit: str | float) -> float:
    """Length of one mesh unit in metres.

    Parameters
    ----------
    unit : str or float
        `m`, `mm`, `cm` or `inch` in any usual spelling (`MM`, `inches`, `millimetres`), or a
        positive number of metres.

    Returns
    -------
    float

    Raises
    ------
    RequestError
        If it is neither.
    """
    if isinstance(unit, str) and (name := named_unit(unit)) is not None:
        return METRES_PER_UNIT[name]
    try:
        length = math.nan if isinstance(unit, (str, bool)) else real_number(unit)
    except NOT_NUMBERS:
        length = math.nan
    if not 0.0 < length < math.inf:
        raise RequestError("a mesh unit of m, mm, cm, inch or a positive number of metres",
                           f"{unit!r}", "most CAD systems export millimetres: 'mm'")
    return length
