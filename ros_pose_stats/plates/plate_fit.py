"""What a fit of a plate finds."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import likelihood, round_parts

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PartEvidence:
    """What one part says about a plate."""

    part_id: str
    part_digest: str
    counted: int
    # indices of the poses of each group, whose poses look alike
    poses: tuple[tuple[int, ...], ...]
    observed: Array  # (G,); shares of the groups as counted, and in the fitted scene
    expected: Array
    error: float  # root mean square of their difference, the noise of the counts taken off; 0 to 1
    # the same in the scene that the other parts alone ask for; NaN where they ask for none, or
    # where this is the only round part
    left_out_error: float
    alone: likelihood.SceneEstimate  # what this part alone asks for


@dataclass(frozen=True, eq=False)
class PlateFit:
    """The scene that stands for a plate."""

    # most likely value and the bounds of its 90 % interval; the height in metres
    restitution: tuple[float, float, float]
    drop_height: tuple[float, float, float]
    # expected root mean square error, over groups of poses, on a part that was not counted
    plate_error: float
    p_value: float  # of the counts in the fitted scene; NaN where nothing is left to test it
    counted: int  # parts of all kinds
    parts: tuple[PartEvidence, ...]
    # most likely sides a turn of round parts, and the least and most of those looked at that the
    # counts do not exclude
    round_sides: tuple[int, int, int] = round_parts.UNTOLD_SIDES
    drops: int = 0  # of all parts, on which the fit rests
    seconds: float = math.nan
