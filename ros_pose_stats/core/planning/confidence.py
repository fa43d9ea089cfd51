"""How sure an estimate is of a part: alone, combined with drops, and with counts of cameras.

Sentences about it are here, too; those of commands, library and node are the same.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ...base import methods, text
from ...base.errors import RequestError
from ..estimators import estimator, expected as expectation
from ..records import Array, DropScene, Index, PoseStatistics, StablePose
from ..records.scene import DEFAULT_PLATE_ERROR, LOW_DROP_RADII
from ..records.statistics import with_shares
from ..resting.poses import RestingPoses
from ..simulation.request import LEAST_TARGET
from ..statistics import errors, fitted_prior
from ..statistics.prior import PosePrior, PriorFit, prior_fit

FIRST_LOOK = (
    10  # drops before the first look at the error: an estimate may need no more
)

WORTHLESS = 0.02
"""An estimate that stands for less than this share of the drops needed is left out."""

SOON = 1.4
"""The first look, in drops for which the expected error is the target; its bound needs more."""

STRANGE = 0.08
"""How likely a part is of a kind that no fit has seen: a judgement, whose outcome is in
docs/measured/benchmarks.md."""

LEAST_POINTS = 0.01  # what is told of an error that symmetry makes vanish


def pose_prior(resting: RestingPoses, scene: DropScene) -> PosePrior:
    """What the default estimate says before the first drop."""
    method = fitted_prior.FITTED_METHOD
    estimate = estimator(method).function(resting, scene)
    expected = expectation.expected_error(method, resting, estimate, scene)
    return _prior(estimate, expected.here, resting, scene)


def prior_of(
    found: PoseStatistics, resting: RestingPoses, scene: DropScene
) -> PosePrior:
    """The same from an estimate that was made before, or its message.

    A drop so low that the estimator does not know it leaves next to nothing of its worth.
    """
    low = (
        scene.drop_height is not None
        and scene.drop_height < LOW_DROP_RADII * resting.body.radius
    )
    known = not low or estimator(found.method).knows_scene
    return _prior(
        [pose.probability for pose in sorted(found.poses, key=lambda pose: pose.index)],
        found.expected_error if known else math.nan,
        resting,
        scene,
    )


def _prior(
    estimate: ArrayLike, expected: float, resting: RestingPoses, scene: DropScene
) -> PosePrior:
    return PosePrior(
        estimate,
        resting.group,
        expected,
        scene.restitution,
        prior_fit(scene.restitution)._replace(strange=STRANGE),
    )


def estimate_bound(prior: PosePrior) -> float:
    """Error that an estimate alone keeps with 90 % confidence; infinite if nothing is known."""
    if not prior.known and len(prior.size) > 1:
        return math.inf
    return prior.updated(np.zeros(prior.unit.shape, dtype=np.int64)).error_quantile()


def worthwhile(prior: PosePrior, target_error: float) -> bool:
    """Whether an estimate, or symmetry, saves a share of the drops that is worth having."""
    return len(prior.size) < len(
        prior.unit
    ) or prior.strength > WORTHLESS * plain_drops(prior, target_error)


def plain_drops(prior: PosePrior, target_error: float) -> float:
    """Drops that have the target as their expected error, if the estimate is about right."""
    spread = prior.mean * (1.0 - prior.mean) / prior.size
    return float(spread.sum()) / (
        len(prior.unit) * max(target_error, LEAST_TARGET) ** 2
    )


def first_look(prior: PosePrior, target_error: float, helped: bool) -> int:
    """Drops before the first look, which costs as much as a dozen; the timing has no say in it."""
    needed = plain_drops(prior, target_error) - (prior.strength if helped else 0.0)
    return max(FIRST_LOOK, int(SOON * needed))


def judge_drops(prior: PosePrior | None, counts: Index) -> errors.Judged:
    """What counts (P,) are worth with an estimate; alone without one, or where they refute it."""
    if prior is None or prior.contradicted(counts).any():
        return errors.judge_counts(counts)
    posterior = prior.updated(counts)
    return errors.Judged(
        posterior.expected_error, posterior.error_quantile(errors.AT_A_LOOK)
    )


def points(error: float) -> str:
    """An error, a fraction, as a number of points."""
    return f"{max(100.0 * error, LEAST_POINTS):.2g} points"


def enough(what: str, bound: float, target_error: float) -> str:
    """Why an answer is kept: its bound keeps the target."""
    return (
        f"{what} is within {points(bound)} with 90 % confidence, and {points(target_error)} "
        f"were asked for."
    )


def not_enough(what: str, bound: float, target_error: float) -> str:
    """Why an answer is not: the beginning of a sentence."""
    return (
        f"{what} is within {points(bound)} with 90 % confidence, not within "
        f"{points(target_error)}"
    )


PLATE_ERRORS = DEFAULT_PLATE_ERROR * 2.0 ** np.linspace(-2.5, 2.5, 11)
"""Errors that a plate nobody has calibrated may have."""

PLATE_ERROR_SPREAD = (
    0.7  # standard deviation of their logarithm before anything was counted
)
ON_PLATES = PriorFit(
    center=0.0, spread=0.5, overrated=0.0, rare_below=0.0, unsure_share=0.5
)
"""A plate contradicts the model of one part more than that of another: strengths scatter by a
factor of 1.6 about what the plate's error implies, and rare poses are believed no more."""


def observe_counts(
    model: PoseStatistics, counts: ArrayLike, left_out: Sequence[float] = ()
) -> PoseStatistics:
    """Combine a result with what cameras counted of the part (P,), as the method `observed`.

    `left_out` (P,): probabilities that the plate's fit says without these counts; they take the
    place of the model where they are of as many poses. Where the counts refute the model beyond
    its error and the plate's, the answer is theirs alone, with the warning `CONFLICT`.
    `expected_error` and `plate_error` both are the error against the plate. Without any count, the
    model itself. Raises RequestError if there are not P counts from 0 up.
    """
    poses = list(model.by_index.values())
    counted = np.asarray(counts)
    if (
        counted.shape != (len(poses),)
        or counted.dtype.kind not in "iu"
        or (counted < 0).any()
    ):
        raise RequestError(
            f"{len(poses)} whole numbers from 0 up, one a pose",
            f"{counted}",
            "count the parts seen in each pose, by its index",
        )
    total = int(counted.sum())
    if not total:
        return model
    told_by_plate = len(left_out) == len(poses)
    if told_by_plate:
        poses = [
            replace(pose, probability=told)
            for pose, told in zip(poses, left_out, strict=True)
        ]
    known = replace(
        model,
        poses=tuple(poses),
        expected_error=0.0 if told_by_plate else model.expected_error,
    )
    prior = plate_prior(known)
    refuted = np.flatnonzero(prior.contradicted(counted))
    warnings = model.warnings
    if refuted.size:
        warnings = (
            *warnings,
            describe_conflict(
                prior,
                counted,
                refuted,
                "the cell contradicts the model",
                "predicted",
                "the answer is that of the counts",
            ),
        )
        prior = plate_prior(replace(known, expected_error=math.nan))
    shares = prior.updated(counted).shares(counted)
    return with_shares(
        model,
        methods.OBSERVED,
        shares,
        plate_error=shares.expected_error,
        drops=0,
        unsettled=0,
        seed=0,
        observed=total,
        warnings=warnings,
    )


def plate_evidence(model: PoseStatistics, counts: ArrayLike) -> Array:
    """Logarithm of the probability of counts (P,) of a part at each of `PLATE_ERRORS`."""
    return np.array(
        [
            plate_prior(replace(model, plate_error=error)).log_evidence(counts)
            for error in PLATE_ERRORS.tolist()
        ]
    )


def learnt_plate_error(evidence: Iterable[Array]) -> float:
    """The plate's error that parts' counts ask for, a geometric mean; without any, the default."""
    far = np.log(PLATE_ERRORS / DEFAULT_PLATE_ERROR)
    logarithm = sum(evidence, -0.5 * np.square(far / PLATE_ERROR_SPREAD))
    weight = np.exp(logarithm - logarithm.max())
    return float(DEFAULT_PLATE_ERROR * np.exp(weight @ far / weight.sum()))


def plate_prior(model: PoseStatistics) -> PosePrior:
    """What a result says of the part on a plate, before anything was counted there."""
    poses = list(model.by_index.values())
    error = math.hypot(model.expected_error, model.plate_error * _of_poses(poses))
    return PosePrior(
        [pose.probability for pose in poses],
        [pose.group for pose in poses],
        error,
        model.restitution,
        ON_PLATES,
    )


def _of_poses(poses: Sequence[StablePose]) -> float:
    """Error over the poses where that over groups, whose poses share it evenly, is 1."""
    group = np.unique([pose.group for pose in poses], return_inverse=True)[1].reshape(
        -1
    )
    size = np.bincount(group)
    share = np.bincount(group, [pose.probability for pose in poses])
    single = share * (1.0 - share)
    return (
        float(np.sqrt((single / size).sum() / size.sum() / single.mean()))
        if (single.any())
        else 1.0
    )


def describe_conflict(
    prior: PosePrior, counts: Index, refuted: Index, who: str, said: str, then: str
) -> str:
    """The warning that counts (P,) contradict a model in some poses, with the one farthest off."""
    expected = (prior.mean / prior.size)[prior.unit]
    share = counts / counts.sum()
    worst = refuted[np.argmax(np.abs(share - expected)[refuted])]
    return (
        f"CONFLICT: {who} in {text.several(refuted.size, 'pose')} "
        f"({text.ranges(refuted.tolist())}), in pose {worst} most: counted "
        f"{text.percent(share[worst])} %, {said} {text.percent(expected[worst])} %; {then}."
    )
