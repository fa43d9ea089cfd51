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

"""How sure an estimate is: alone, with drops, and with counts of cameras.

Sentences about it are here, too; those of commands, library and node are the same.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ...base import methods, text
from ...base.errors import RequestError
from ..estimators import estimator
from ..estimators.expected import expected_error
from ..records import Array, DropScene, Index, PoseStatistics, StablePose
from ..records.notes import Note, note
from ..records.scene import DEFAULT_PLATE_ERROR, LOW_DROP_RADII
from ..records.shares import with_shares
from ..resting.poses import RestingPoses
from ..statistics import errors, fitted_prior
from ..statistics.chi_square import goodness_of_fit
from ..statistics.model_gap import USUAL_ERRORS, Forecast, share_errors
from ..statistics.prior import FALSE_ALARM_CHANCE, PosePrior, PriorFit, prior_fit

STRANGE_CHANCE = 0.08
"""How likely a part is of a kind that no fit has seen: a judgement, whose outcome is in
docs/measured/benchmarks.md. About as many parts are off by more than twice what is
told."""

DOUBT = 0.95
"""The same as errors are told by where drops stand beside the estimate: some more of
them are needed where it is right, and the errors are kept where it is wrong."""

SMALLEST_POINTS = 0.01  # what is told of an error that symmetry makes vanish


def pose_prior(resting: RestingPoses, scene: DropScene) -> PosePrior:
    """What the default estimate says before the first drop."""
    method = fitted_prior.FITTED_METHOD
    estimate = estimator(method).function(resting, scene)
    expected = expected_error(method, resting, estimate, scene)
    return _prior(estimate, expected.part_error, resting, scene, DOUBT)


def estimate_prior(
    estimate: PoseStatistics,
    resting: RestingPoses,
    scene: DropScene,
    doubt: float = DOUBT,
) -> PosePrior:
    """The same from an estimate that was made before, or its message.

    A drop so low that the estimator does not know it leaves next to nothing of its
    worth.
    """
    is_low = (
        scene.drop_height is not None
        and scene.drop_height < LOW_DROP_RADII * resting.body.radius
    )
    knows_scene = not is_low or estimator(estimate.method).knows_scene
    return _prior(
        [
            pose.probability
            for pose in sorted(estimate.poses, key=lambda pose: pose.index)
        ],
        estimate.expected_error if knows_scene else math.nan,
        resting,
        scene,
        doubt,
    )


def _prior(
    estimate: ArrayLike,
    expected: float,
    resting: RestingPoses,
    scene: DropScene,
    doubt: float,
) -> PosePrior:
    return PosePrior(
        estimate,
        resting.unit,
        expected,
        scene.restitution,
        prior_fit(scene.restitution)._replace(strange=STRANGE_CHANCE, doubt=doubt),
        resting.group,
    )


def estimate_bound(
    estimate: PoseStatistics, resting: RestingPoses, scene: DropScene
) -> float:
    """Error that an estimate alone keeps with 90 % confidence; infinite if unknown."""
    prior = estimate_prior(estimate, resting, scene, STRANGE_CHANCE)
    if not prior.has_expected_error and len(prior.size) > 1:
        return math.inf
    return prior.update(np.zeros(prior.unit.shape, dtype=np.int64)).error_quantile()


def judge_drops(prior: PosePrior | None, counts: Index) -> errors.Judgement:
    """Judge counts (P,) with an estimate; alone without one, or if they refute it.

    With one, the bound is kept over the poses and over the shares of groups.
    """
    if prior is None:
        return errors.judge_counts(counts)
    if prior.contradicted_poses(counts).any():
        judgement = errors.judge_counts(counts)
        row_counts = np.bincount(prior.row, counts).astype(np.int64)
        row_bound = errors.counted_bound(row_counts)
        return judgement._replace(bound=max(judgement.bound, row_bound))
    posterior = prior.update(counts)
    return errors.Judgement(
        posterior.expected_error, posterior.error_quantile(errors.CHECKPOINT_LEVEL)
    )


def points(error: float) -> str:
    """An error, a fraction, as a number of points."""
    return f"{max(100.0 * error, SMALLEST_POINTS):.2g} points"


def explain_kept_target(subject: str, bound: float, target_error: float) -> str:
    """Why an answer is kept: its bound keeps the target."""
    return (
        f"{subject}: within {points(bound)} with 90 % confidence, and the target is "
        f"{points(target_error)}."
    )


def explain_missed_target(subject: str, bound: float, target_error: float) -> str:
    """Why an answer is not: the beginning of a sentence."""
    return (
        f"{subject}: within {points(bound)} with 90 % confidence, not within "
        f"{points(target_error)}"
    )


PLATE_ERRORS = DEFAULT_PLATE_ERROR * 2.0 ** np.linspace(-2.5, 2.5, 11)
"""Errors that a plate nobody has calibrated may have."""

PLATE_ERROR_SPREAD = 0.7
"""Standard deviation of their logarithm before anything was counted."""
PLATE_FIT = PriorFit(
    center=0.0, spread=0.5, overrated=0.0, rare_below=0.0, unsure_share=0.5
)
"""A plate contradicts the model of one part more than that of another: strengths
scatter by a factor of 1.6 about what the plate's error implies, and rare poses are
believed no more."""


def observe_counts(
    model: PoseStatistics, counts: ArrayLike, left_out: Sequence[float] = ()
) -> PoseStatistics:
    """Combine a result with what cameras counted (P,), as the method `observed`.

    `left_out` (P,): probabilities that the plate's fit says without these counts; they
    take the place of the model where they are of as many poses. Where the counts refute
    the model beyond its error and the plate's, the answer is theirs alone, with the
    warning `CONFLICT`. Poses of a group share their counts unless these differ by more
    than chance, as on a plate that has a hand; then each has its own, with the same
    warning. `expected_error` and `plate_error` both are the error against
    the plate, and `model_gap` is what lies between the prediction and the shares that
    were counted. A gap that is neither chance nor the model's own error has the note
    `MODEL_GAP`, unless the counts refute the model; on a plate that was fitted one of
    more than twice its error. Without any count, the model itself. Raises RequestError
    if there are not P counts from 0 up.
    """
    poses = list(model.by_index.values())
    pose_counts = _check_counts(counts, len(poses))
    total = int(pose_counts.sum())
    if not total:
        return model
    has_plate_shares = len(left_out) == len(poses)
    prediction = _told_by_plate(model, left_out) if has_plate_shares else model
    counted_shares = pose_counts / total
    gap = errors.root_mean_square(prediction.column("probability") - counted_shares)
    unequal_groups = find_unequal_groups(poses, pose_counts)
    unit = [
        -1 - pose.index if pose.group in unequal_groups else pose.group
        for pose in poses
    ]
    warnings = [
        *model.warnings,
        *(
            _inequality_note(indices, counted_shares)
            for indices in unequal_groups.values()
        ),
    ]
    prior = plate_prior(prediction, unit)
    forecast = _forecast(prediction, is_fitted=has_plate_shares)
    refuted = np.flatnonzero(prior.contradicted_poses(pose_counts))
    if refuted.size:
        warnings.append(_refutation_note(prior, pose_counts, refuted, forecast))
        prior = plate_prior(replace(prediction, expected_error=math.nan), unit)
    elif not has_plate_shares or gap > USUAL_ERRORS * model.plate_error:
        words = forecast.describe_gap(pose_counts)
        if words:
            text_of_gap = f"{words}; the answer has learnt from the counts."
            warnings.append(note("MODEL_GAP", text_of_gap))
    shares = prior.update(pose_counts).shares(pose_counts)
    return with_shares(
        model,
        methods.OBSERVED,
        shares,
        plate_error=shares.expected_error,
        drops=0,
        unsettled=0,
        seed=0,
        counted_parts=total,
        model_gap=gap,
        warnings=tuple(warnings),
    )


def _check_counts(counts: ArrayLike, poses: int) -> Index:
    """Counts (P,) as an array; raises RequestError if there are not P from 0 up."""
    pose_counts = np.asarray(counts)
    if (
        pose_counts.shape != (poses,)
        or pose_counts.dtype.kind not in "iu"
        or (pose_counts < 0).any()
    ):
        raise RequestError(
            f"{poses} whole numbers from 0 up, one a pose",
            f"{pose_counts}",
            "count the parts seen in each pose, by its index",
        )
    return pose_counts


def _told_by_plate(
    model: PoseStatistics, probabilities: Sequence[float]
) -> PoseStatistics:
    """What the fit of a plate says of the poses, which errs by the plate's error."""
    return replace(
        model,
        poses=tuple(
            pose.with_values(probability=probability)
            for pose, probability in zip(
                model.by_index.values(), probabilities, strict=True
            )
        ),
        expected_error=0.0,
    )


def _refutation_note(
    prior: PosePrior, counts: Index, refuted: Index, forecast: Forecast
) -> Note:
    """Of a model that counts (P,) contradict in some poses."""
    consequences = [
        *forecast.describe_unreported(counts),
        "the answer is that of the counts",
    ]
    return describe_conflict(
        prior,
        counts,
        refuted,
        "the cell contradicts the model",
        "predicted",
        "; ".join(consequences),
    )


def _inequality_note(indices: list[int], shares: Array) -> Note:
    """Of poses that are the same by symmetry, and have unequal shares (P,)."""
    lowest, highest = shares[indices].min(), shares[indices].max()
    return note(
        "CONFLICT",
        f"{text.name_poses(indices)} are the same by symmetry, and the cell counted "
        f"{text.percent(lowest)} to {text.percent(highest)} %; each is answered by its "
        "own counts.",
    )


def _forecast(prediction: PoseStatistics, *, is_fitted: bool) -> Forecast:
    """What a prediction says of counts; the fit of a plate errs by the plate's error.

    `is_fitted`: whether it is what the fit says.
    """
    probability = prediction.column("probability")
    errors_of_poses: Array = np.zeros(probability.size)
    drop_counts = None
    if not is_fitted:
        errors_of_poses = share_errors(
            probability,
            prediction.column("standard_error"),
            prediction.expected_error,
        )
        if prediction.method == methods.SIMULATION:
            drop_counts = prediction.column("count")
    return Forecast(
        probability,
        errors_of_poses,
        prediction.plate_error,
        drop_counts,
        prediction.column("group"),
        np.arange(probability.size),
    )


def find_unequal_groups(
    poses: Sequence[StablePose], counts: Index
) -> dict[int, list[int]]:
    """Groups whose poses were counted unequally beyond chance, with their indices."""
    groups: dict[int, list[int]] = {}
    for pose in poses:
        groups.setdefault(pose.group, []).append(pose.index)
    return {
        group: indices
        for group, indices in groups.items()
        if goodness_of_fit(counts[indices], np.ones(len(indices))).p_value
        < FALSE_ALARM_CHANCE / len(groups)
    }


def plate_evidence(model: PoseStatistics, counts: ArrayLike) -> Array:
    """Log probability of counts (P,) of a part at each of `PLATE_ERRORS`."""
    return np.array(
        [
            plate_prior(replace(model, plate_error=error)).log_evidence(counts)
            for error in PLATE_ERRORS.tolist()
        ]
    )


def learn_plate_error(evidence: Iterable[Array]) -> float:
    """The plate's error by counts of parts, a geometric mean; the default without."""
    log_ratio = np.log(PLATE_ERRORS / DEFAULT_PLATE_ERROR)
    logarithm = sum(evidence, -0.5 * np.square(log_ratio / PLATE_ERROR_SPREAD))
    weight = np.exp(logarithm - logarithm.max())
    return float(DEFAULT_PLATE_ERROR * np.exp(weight @ log_ratio / weight.sum()))


def plate_prior(model: PoseStatistics, unit: Sequence[int] | None = None) -> PosePrior:
    """What a result says of the part on a plate, before anything was counted there.

    `unit` (P,): poses of one number share their counts; groups without.
    """
    probability = model.column("probability")
    group = model.column("group")
    plate_error = model.plate_error * _pose_error_ratio(probability, group)
    return PosePrior(
        probability,
        group if unit is None else unit,
        math.hypot(model.expected_error, plate_error),
        model.restitution,
        PLATE_FIT,
    )


def _pose_error_ratio(probability: Array, group: Index) -> float:
    """Error over the poses for one of 1 over groups, whose poses share it evenly."""
    number = np.unique(group, return_inverse=True)[1]
    size = np.bincount(number)
    share = np.bincount(number, probability)
    single_drop = share * (1.0 - share)
    if not single_drop.any():
        return 1.0
    pose_mean = (single_drop / size).sum() / size.sum()
    return float(np.sqrt(pose_mean / single_drop.mean()))


def describe_conflict(
    prior: PosePrior,
    counts: Index,
    refuted: Index,
    subject: str,
    verb: str,
    consequence: str,
) -> Note:
    """Warning that counts (P,) contradict a model in some poses, and where most."""
    return note(
        "CONFLICT",
        f"{subject} in {text.several(refuted.size, 'pose')} "
        f"({text.ranges(refuted.tolist())}), "
        f"{describe_extreme(prior, counts, refuted, verb)}; {consequence}.",
    )


def describe_extreme(prior: PosePrior, counts: Index, refuted: Index, verb: str) -> str:
    """In which of some poses counts (P,) are farthest from a model, and how far."""
    expected = (prior.mean / prior.size)[prior.unit]
    share = counts / counts.sum()
    worst = refuted[np.argmax(np.abs(share - expected)[refuted])]
    return (
        f"in pose {worst} most: counted {text.percent(share[worst])} %, {verb} "
        f"{text.percent(expected[worst])} %"
    )
