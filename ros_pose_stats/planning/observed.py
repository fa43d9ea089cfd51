"""A model's answer combined with what cameras counted on the plate itself."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import RequestError
from ..methods import OBSERVED
from ..records import PoseStatistics, StablePose
from ..records.statistics import with_shares
from ..statistics.prior import PosePrior, PriorFit
from ..text import percent, ranges, several

Index = NDArray[np.int64]

ON_PLATES: Final = PriorFit(center=0.0, spread=0.5, overrated=0.0, rare_below=0.0,
                            unsure_share=0.5)
"""A plate contradicts the model of one part more than that of another: strengths scatter by a
factor of 1.6 about what the plate's error implies, and rare poses are believed no more."""


def observe_counts(model: PoseStatistics, counts: ArrayLike) -> PoseStatistics:
    """Combine a result with what cameras counted of the part.

    The model is believed as far as its own error and that of the plate allow; how well the counts
    agree with it weighs in. Poses that symmetry makes equal share their counts.

    `model`: an estimate or of drops, with `plate_error`; `counts` (P,) int: parts seen in each
    pose, by `index`. Returns with the method `observed`: probabilities are posterior means,
    intervals the shortest ones of 90 %, `count` what was counted, and `expected_error` and
    `plate_error` both the error against the plate. Where the counts refute the model beyond both
    errors, the answer is theirs alone, with the warning `CONFLICT`. Without any count, the model
    itself. Raises RequestError if there are not P counts from 0 up.
    """
    poses = sorted(model.poses, key=lambda pose: pose.index)
    counted = np.asarray(counts)
    if counted.shape != (len(poses),) or counted.dtype.kind not in "iu" or (counted < 0).any():
        raise RequestError(f"{len(poses)} whole numbers from 0 up, one a pose", f"{counted}",
                           "count the parts seen in each pose, by its index")
    total = int(counted.sum())
    if not total:
        return model
    prior = plate_prior(model)
    refuted = np.flatnonzero(prior.contradicted(counted))
    warnings = model.warnings
    if refuted.size:
        warnings = (*warnings, _describe_conflict(prior, counted, refuted))
        prior = plate_prior(replace(model, expected_error=math.nan))
    shares = prior.updated(counted).shares(counted)
    return with_shares(model, OBSERVED, shares, plate_error=shares.expected_error, drops=0,
                       unsettled=0, seed=0, observed=total, warnings=warnings)


def plate_prior(model: PoseStatistics) -> PosePrior:
    """What a result says of the part on a plate, before anything was counted there.

    `model`: where its `expected_error` is not known, counts have the say.
    """
    poses = sorted(model.poses, key=lambda pose: pose.index)
    error = math.hypot(model.expected_error, model.plate_error * _of_poses(poses))
    return PosePrior([pose.probability for pose in poses], [pose.group for pose in poses], error,
                     model.restitution, ON_PLATES)


def _of_poses(poses: Sequence[StablePose]) -> float:
    """Error over the poses where that over groups of poses that look alike is 1.

    A plate's error is known over groups, whose poses share it evenly.
    """
    group = np.unique([pose.group for pose in poses], return_inverse=True)[1].reshape(-1)
    size = np.bincount(group)
    share = np.bincount(group, [pose.probability for pose in poses])
    single = share * (1.0 - share)
    return float(np.sqrt((single / size).sum() / size.sum() / single.mean())) if (
        single.any()) else 1.0


def _describe_conflict(prior: PosePrior, counted: Index, refuted: Index) -> str:
    """The warning, with the pose that is farthest off."""
    told = (prior.mean / prior.size)[prior.unit]
    share = counted / counted.sum()
    worst = refuted[np.argmax(np.abs(share - told)[refuted])]
    return (f"CONFLICT: the cell contradicts the model in {several(refuted.size, 'pose')} "
            f"({ranges(refuted.tolist())}), in pose {worst} most: counted "
            f"{percent(share[worst])} %, predicted {percent(told[worst])} %; the answer is that "
            f"of the counts.")
