"""What a fit of a plate finds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .likelihood import SceneEstimate
from .round_parts import UNTOLD_SIDES

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PartEvidence:
    """What one part says about a plate.

    Attributes
    ----------
    part_id, part_digest : str
    counted : int
    poses : tuple of tuple of int
        Indices of the poses of each group, whose poses look alike.
    observed, expected : (G,) arrays
        Shares of the groups as counted, and in the fitted scene.
    error : float
        Root mean square of their difference, the noise of the counts taken off; 0 to 1.
    left_out_error : float
        The same in the scene that the other parts alone ask for; NaN where they ask for none, or
        where this is the only round part.
    alone : SceneEstimate
        What this part alone asks for.
    """

    part_id: str
    part_digest: str
    counted: int
    poses: tuple[tuple[int, ...], ...]
    observed: Array
    expected: Array
    error: float
    left_out_error: float
    alone: SceneEstimate


@dataclass(frozen=True, eq=False)
class PlateFit:
    """The scene that stands for a plate.

    Attributes
    ----------
    restitution, drop_height : tuple of float
        Most likely value and the bounds of its 90 % interval; the height in metres.
    plate_error : float
        Expected root mean square error, over groups of poses, on a part that was not counted.
    p_value : float
        Of the counts in the fitted scene; NaN where nothing is left to test it.
    counted : int
        Parts of all kinds.
    parts : tuple of PartEvidence
    round_sides : tuple of int
        Most likely sides a turn of round parts, and the least and most of those looked at that
        the counts do not exclude.
    drops : int
        Of all parts, on which the fit rests.
    seconds : float
    """

    restitution: tuple[float, float, float]
    drop_height: tuple[float, float, float]
    plate_error: float
    p_value: float
    counted: int
    parts: tuple[PartEvidence, ...]
    round_sides: tuple[int, int, int] = UNTOLD_SIDES
    drops: int = 0
    seconds: float = math.nan
