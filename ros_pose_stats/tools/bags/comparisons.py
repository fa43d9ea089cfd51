"""Bags analysed: predictions beside each other, and beside what cameras counted."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ...core.records import Array, Index
from ...core.statistics import chi_square, errors
from . import bag_reader, camera_counts
from .results import PoseTable, Prediction, ResultHistory


@dataclass(frozen=True, eq=False)
class Comparison:
    """A prediction set against counts: those of a simulation, or a camera's."""

    prediction: Prediction
    share: Array  # (K,); the counts as fractions of their sum, in the order of the pose table
    # root mean square and largest difference of probability and share over the poses, as
    # fractions; NaN without counts
    rms: float
    largest: float
    largest_pose: int  # index of the pose with the largest difference
    # whether chance explains the differences: that of the counts, and that of the prediction,
    # which is a count itself or is as far off as it says
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

    counts: camera_counts.CameraCounts
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

    record: bag_reader.PartRecord
    simulations: tuple[
        tuple[SimulationComparison, ...], ...
    ]  # of each of the record's histories
    counts: tuple[CountComparison, ...]  # one a plate, drop height and numbering


@dataclass(frozen=True, eq=False)
class BagAnalysis:
    """All parts."""

    contents: bag_reader.BagContents
    parts: tuple[PartAnalysis, ...]
    strays: tuple[
        CountComparison, ...
    ]  # camera counts of parts that no result is about


def analyse_bags(
    paths: bag_reader.Paths, on_progress: bag_reader.OnProgress | None = None
) -> BagAnalysis:
    """Read bags and compare estimates, simulations and camera counts in them.

    Parameters
    ----------
    paths : path or iterable of path
        Bag directories (of the node, or recorded by `ros2 bag record`), directories of many
        bags, or single files.
    on_progress : callable, optional
        Told now and then how many bytes have been read, and of how many.

    Returns
    -------
    BagAnalysis
        Its `parts` hold numpy arrays in the order of each part's pose table.

    Raises
    ------
    BagError
        If there is no bag, a named file cannot be read, or no message of this package's types
        is in any of them.
    """
    contents = bag_reader.read_bags(paths, on_progress)
    compared: dict[int, list[CountComparison]] = {}
    for counts in contents.counts:
        place, comparison = _compared(counts, contents.parts)
        compared.setdefault(place, []).append(comparison)
    parts = tuple(
        PartAnalysis(
            record,
            tuple(
                tuple(_simulation_comparisons(history)) for history in record.histories
            ),
            tuple(compared.get(place, ())),
        )
        for place, record in enumerate(contents.parts)
    )
    return BagAnalysis(contents, parts, tuple(compared.get(-1, ())))


def _compared(
    counts: camera_counts.CameraCounts, parts: tuple[bag_reader.PartRecord, ...]
) -> tuple[int, CountComparison]:
    """Which part (-1: none) counts belong to, and what they are compared with."""
    # With the counts' digest, or without one their name; the same name first.
    fitting = sorted(
        (
            place
            for place, part in enumerate(parts)
            if (
                part.part_digest == counts.part_digest
                if counts.part_digest
                else part.part_id == counts.part_id
            )
        ),
        key=lambda place: (
            parts[place].part_id != counts.part_id,
            not parts[place].histories,
        ),
    )
    if not fitting:
        return -1, CountComparison(counts, "no result of this part is in the bags")
    place = fitting[0]
    digests = {parts[each].part_digest for each in fitting}
    if len(digests) > 1:
        return -1, CountComparison(
            counts,
            f"the counts carry no digest, and {len(digests)} parts are called "
            f"{counts.part_id}",
        )
    histories = parts[place].histories
    for history in histories:
        if history.numbering.agrees(counts.numbering):
            return place, _count_comparison(counts, history)
    known = "; ".join(str(each.numbering) for each in histories) or "none"
    return place, CountComparison(
        counts,
        f"counted at {counts.numbering}, results are at {known}: the same index is not "
        "the same pose",
    )


def _compare(prediction: Prediction, counts: Index, poses: PoseTable) -> Comparison:
    """Set a prediction against counts (K,) in the order of the pose table."""
    share = _shares(counts)
    apart = np.abs(prediction.probability - share)
    known = bool(np.isfinite(apart).all())
    groups = np.unique(poses.group, return_inverse=True)[1]
    by_pose = _test(prediction, counts, np.arange(counts.size), groups)
    by_group = _test(prediction, counts, groups, np.arange(counts.size))
    return Comparison(
        prediction,
        share,
        errors.root_mean_square(apart),
        float(apart.max()),
        int(poses.index[apart.argmax()]) if known else -1,
        by_pose,
        by_group,
        int(counts[prediction.probability == 0.0].sum()),
    )


def _shares(counts: Index) -> Array:
    total = counts.sum()
    return counts / total if total else np.full(counts.shape, math.nan)


def _test(
    prediction: Prediction, counts: Index, bins: Index, unit: Index
) -> chi_square.ChiSquare:
    """Counts in bins against a prediction with its own scatter, which bins of a unit share."""
    observed = np.bincount(bins, counts)
    if prediction.counted:
        return chi_square.homogeneity(observed, np.bincount(bins, prediction.count))
    probability = np.nan_to_num(np.bincount(bins, prediction.probability))
    if not probability.sum() > 0.0:
        return chi_square.goodness_of_fit(
            np.zeros(1), np.ones(1)
        )  # nothing was predicted
    return chi_square.goodness_of_fit(
        observed,
        probability,
        np.bincount(bins, prediction.errors),
        unit[: observed.size],
    )


def _simulation_comparisons(history: ResultHistory) -> Iterator[SimulationComparison]:
    """Every simulation beside the estimates of its scene, and those that are blind to a scene."""
    for simulation in history.foretold:
        scene = simulation.restitution, simulation.drop_height
        beside = [
            one
            for one in history.foretold
            if not one.counted
            and (
                math.isnan(one.drop_height)
                or (one.restitution, one.drop_height) == scene
            )
        ]
        if simulation.counted and beside:
            yield SimulationComparison(
                simulation,
                tuple(_compare(one, simulation.count, history.poses) for one in beside),
            )


def _count_comparison(
    counts: camera_counts.CameraCounts, history: ResultHistory
) -> CountComparison:
    """Counts beside every prediction of the poses that they number."""
    index = history.poses.index
    unknown = counts.index[~np.isin(counts.index, index)]
    if unknown.size:
        return CountComparison(
            counts,
            f"pose {unknown[0]} was counted, which the part does not have: the poses are "
            "numbered differently",
        )
    aligned = np.zeros(index.shape, dtype=np.int64)
    aligned[np.searchsorted(index, counts.index)] = counts.count
    return CountComparison(
        counts,
        "",
        history,
        aligned,
        tuple(_compare(one, aligned, history.poses) for one in history.foretold),
        tuple(_remarks(counts, history)),
    )


def _remarks(
    counts: camera_counts.CameraCounts, history: ResultHistory
) -> Iterator[str]:
    if np.unique(history.poses.group).size < history.poses.index.size:
        yield (
            "poses of one group look alike: a camera that cannot tell them apart is judged by "
            "group alone"
        )
    plates = sorted({one.plate for one in history.predictions if one.plate})
    if counts.plate and plates and counts.plate not in plates:
        yield f"counted on plate {counts.plate}, predicted for {', '.join(plates)}"
    for one in history.predictions:
        if (
            math.isfinite(counts.drop_height)
            and math.isfinite(one.drop_height)
            and not (math.isclose(counts.drop_height, one.drop_height, rel_tol=0.05))
        ):
            yield (
                f"counted after drops from {counts.drop_height * 1e3:.4g} mm, {one.method} "
                f"from {one.drop_height * 1e3:.4g} mm"
            )
