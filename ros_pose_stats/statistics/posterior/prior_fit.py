"""The numbers of the prior between the restitutions that they were fitted at."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .fitted import FITTED, FITTED_AT


class PriorFit(NamedTuple):
    """How a method's estimates err, beyond the expected error of each part.

    Attributes
    ----------
    center : float
        Natural logarithm of the typical strength of the estimate over the one that its
        expected error implies.
    spread : float
        Scale of that logarithm over parts, above 0.
    overrated : float
        Probability that the method overrates by a factor of two, 0 to 1: poses far below it
        are in truth rarer still.
    rare_below : float
        Probability below which a pose's estimate is stronger, in pseudo-drops, than the
        others', 0 to 1.
    unsure_share : float
        Share of poses that are estimated no more surely than the others though they are rare,
        above 0 and below 1.
    """

    center: float
    spread: float
    overrated: float
    rare_below: float
    unsure_share: float


def prior_fit(restitution: float) -> PriorFit:
    """The fit at a restitution, straight between those measured, the nearest one beyond.

    Parameters
    ----------
    restitution : float
        0 <= restitution < 1.
    """
    return PriorFit(*(float(np.interp(restitution, FITTED_AT, column))
                      for column in zip(*FITTED, strict=True)))
