"""Units of mesh files."""

from __future__ import annotations

import math
from typing import Final

from ..errors import RequestError
from .arrays import NOT_NUMBERS, real_number

METRES_PER_UNIT: Final = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254}


def metres_per_unit(unit: str | float) -> float:
    """Length of one mesh unit in metres.

    Parameters
    ----------
    unit : str or float
        `m`, `mm`, `cm` or `inch`, or a positive number of metres.

    Returns
    -------
    float

    Raises
    ------
    RequestError
        If it is neither.
    """
    if isinstance(unit, str) and unit in METRES_PER_UNIT:
        return METRES_PER_UNIT[unit]
    try:
        length = math.nan if isinstance(unit, (str, bool)) else real_number(unit)
    except NOT_NUMBERS:
        length = math.nan
    if not 0.0 < length < math.inf:
        raise RequestError("a mesh unit of m, mm, cm, inch or a positive number of metres",
                           f"{unit!r}", "most CAD systems export millimetres: 'mm'")
    return length
