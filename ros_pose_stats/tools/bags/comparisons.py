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

"""Bags analysed: predictions beside each other, and beside what cameras counted."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...core.records import Array, Index
from ...core.statistics import chi_square, errors
from .bag_reader import BagContents, OnProgress, PartRecord, Paths, read_bags
from .camera_counts import CameraCounts
from .results import PoseTable, Prediction, ResultHistory

SAME_HEIGHT = 0.05  # relative difference of drop heights that are taken for the same


@dataclass(frozen=True, eq=False)
class Comparison:
    """A prediction set against counts: those of a simulation, or a camera's."""

    prediction: Prediction
    # (K,); the counts as fractions of their sum, in the order of the pose table
    share: Array
    # root mean square and largest difference of probability and share over the poses,
    # as fractions; NaN without counts
    rms: float
    largest: float
    largest_pose: int  # with the largest difference, its index; -1 without counts
    # whether chance explains the differences: that of the counts, and that of the
    # prediction, which is a count itself or is as far off as it says
    by_pose: chi_square.ChiSquare
    by_group: chi_square.ChiSquare
    unforeseen: int  # counts in poses whose predicted probability is 0


@dataclass(frozen=True, eq=False)
class SimulationComparison:
    """Estimates set against one simulation."""

    simulation: Prediction
    estimates: tuple[Comparison, ...]


@dataclass(frozen=True, eq=False)
class CountComparison:
    """What cameras counted, set against every prediction of the same poses."""

    counts: CameraCounts
    problem: str  # why the counts cannot be compared; empty where they can
    # the results that number the poses alike; None where the counts cannot be compared
    history: ResultHistory | None = None
    # (K,) int; parts in each pose, in the order of the pose table; empty without one
    count: Index = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    predictions: tuple[Comparison, ...] = ()
    remarks: tuple[str, ...] = ()  # what to bear in mind

    @property
    def share(self) -> Array:
        """Fraction of all counts in stable poses, (K,)."""
        return _shares(self.count)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Bounds of the 90 % interval of each share."""
        return errors.jeffreys_interval(self.count, self.count.sum())


@dataclass(frozen=True, eq=False)
class PartAnalysis:
    """One part."""

    record: PartRecord
    # of each of the record's histories
    simulations: tuple[tuple[SimulationComparison, ...], ...]
    counts: tuple[CountComparison, ...]  # one a plate, drop height and numbering


@dataclass(frozen=True, eq=False)
class BagAnalysis:
    """All parts."""

    contents: BagContents
    parts: tuple[PartAnalysis, ...]
    strays: tuple[CountComparison, ...]  # camera counts of parts without any result


def analyse_bags(
    paths: Paths,
    on_progress: OnProgress | None = None,
    table_counts: Sequence[CameraCounts] = (),
) -> BagAnalysis:
    """Read bags and compare estimates, simulations and camera counts in them.

    Parameters
    ----------
    paths : path or iterable of path
        Bag directories (of the node, or recorded by `ros2 bag record`), directories of
        many bags, or single files.
    on_progress : callable, optional
        Told now and then how many bytes have been read, and of how many.
    table_counts : sequence of CameraCounts
        Counts from elsewhere, which are compared as those in the bags are.

    Returns
    -------
    BagAnalysis
        Its `parts` hold numpy arrays in the order of each part's pose table.

    Raises
    ------
    BagError
        If there is no bag, a named file cannot be read, or no message of this package's
        types is in any of them.
    """
    contents = read_bags(paths, on_progress)
    counts_of_part: dict[PartRecord | None, list[CountComparison]] = {}
    for counts in (*contents.counts, *table_counts):
        part, comparison = _compare_counts(counts, contents.parts)
        counts_of_part.setdefault(part, []).append(comparison)
    parts = tuple(
        PartAnalysis(
            part,
            tuple(
                tuple(_simulation_comparisons(history)) for history in part.histories
            ),
            tuple(counts_of_part.get(part, ())),
        )
        for part in contents.parts
    )
    return BagAnalysis(contents, parts, tuple(counts_of_part.get(None, ())))


def _compare_counts(
    counts: CameraCounts, parts: tuple[PartRecord, ...]
) -> tuple[PartRecord | None, CountComparison]:
    """Which part, if any, counts belong to, and what they are compared with."""
    # With the counts' digest, or without one their name; the same name first.
    candidates = [
        part for part in parts if counts.are_of(part.part_id, part.part_digest)
    ]
    candidates.sort(
        key=lambda part: (part.part_id != counts.part_id, not part.histories)
    )
    if not candidates:
        return None, CountComparison(counts, "no result of this part is in the bags")
    digests = {part.part_digest for part in candidates}
    if len(digests) > 1:
        return None, CountComparison(
            counts,
            f"the counts carry no digest, and {len(digests)} parts are called "
            f"{counts.part_id}",
        )
    part = candidates[0]
    for history in part.histories:
        if history.numbering.agrees(counts.numbering):
            return part, _count_comparison(counts, history)
    if counts.unknown_code:
        return part, CountComparison(
            counts,
            f"counted under numbering {counts.unknown_code}, which no result of the "
            "part has: the same index is not the same pose",
        )
    numberings = "; ".join(str(history.numbering) for history in part.histories)
    return part, CountComparison(
        counts,
        f"counted at {counts.numbering}, results are at {numberings or 'none'}: the "
        "same index is not the same pose",
    )


def _compare(prediction: Prediction, counts: Index, poses: PoseTable) -> Comparison:
    """Set a prediction against counts (K,) in the order of the pose table."""
    share = _shares(counts)
    differences = np.abs(prediction.probability - share)
    are_known = bool(np.isfinite(differences).all())
    forecast = prediction.forecast(poses)
    return Comparison(
        prediction,
        share,
        errors.root_mean_square(differences),
        float(differences.max()),
        int(poses.index[differences.argmax()]) if are_known else -1,
        forecast.test_by_pose(counts),
        forecast.test_by_group(counts),
        int(counts[prediction.probability == 0.0].sum()),
    )


def _shares(counts: Index) -> Array:
    total = counts.sum()
    return counts / total if total else np.full(counts.shape, math.nan)


def _simulation_comparisons(history: ResultHistory) -> Iterator[SimulationComparison]:
    """Every simulation beside the estimates of its scene and those blind to a scene."""
    for simulation in history.foretold:
        scene = simulation.restitution, simulation.drop_height
        estimates = [
            prediction
            for prediction in history.foretold
            if not prediction.counted
            and (
                math.isnan(prediction.drop_height)
                or (prediction.restitution, prediction.drop_height) == scene
            )
        ]
        if simulation.counted and estimates:
            comparisons = [
                _compare(estimate, simulation.count, history.poses)
                for estimate in estimates
            ]
            yield SimulationComparison(simulation, tuple(comparisons))


def _count_comparison(counts: CameraCounts, history: ResultHistory) -> CountComparison:
    """Counts beside every prediction of the poses that they number."""
    index = history.poses.index
    unknown = counts.index[~np.isin(counts.index, index)]
    if unknown.size:
        return CountComparison(
            counts,
            f"pose {unknown[0]} was counted, which the part does not have: the poses "
            "are numbered differently",
        )
    aligned = np.zeros(index.shape, dtype=np.int64)
    aligned[np.searchsorted(index, counts.index)] = counts.count
    return CountComparison(
        counts,
        "",
        history,
        aligned,
        tuple(
            _compare(prediction, aligned, history.poses)
            for prediction in history.foretold
        ),
        tuple(_remarks(counts, history)),
    )


def _remarks(counts: CameraCounts, history: ResultHistory) -> Iterator[str]:
    if np.unique(history.poses.group).size < history.poses.index.size:
        yield (
            "poses of one group look alike: a camera that cannot tell them apart is "
            "judged by group alone"
        )
    plates = {prediction.plate for prediction in history.predictions} - {""}
    if counts.plate and plates and counts.plate not in plates:
        names = ", ".join(sorted(plates))
        yield f"counted on plate {counts.plate}, predicted for {names}"
    if not math.isfinite(counts.drop_height):
        return
    for prediction in history.predictions:
        height = prediction.drop_height
        if math.isfinite(height) and not math.isclose(
            counts.drop_height, height, rel_tol=SAME_HEIGHT
        ):
            yield (
                f"counted after drops from {counts.drop_height * 1e3:.4g} mm, "
                f"{prediction.method} from {height * 1e3:.4g} mm"
            )
