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

"""Predictions beside simulations and camera counts, in the report on bags."""

import math
from collections.abc import Iterator, Sequence
from itertools import islice
from textwrap import wrap

import numpy as np

from ....base import text
from ....base.text import Column, columns, interval, percent, several, utc
from ....core.records import Array, Index
from ....core.statistics import chi_square, errors
from ....core.statistics.model_gap import BEYOND_CHANCE
from ...bags import camera_counts, comparisons, results

LabelledShares = tuple[str, Array]  # the label of a prediction, and its shares

WITHIN_CHANCE = 0.05


def wrapped(line: str, indent: str = "") -> list[str]:
    """A line of the report on as many as the terminal needs."""
    return wrap(
        text.printable(line),
        text.WIDTH,
        initial_indent=indent,
        subsequent_indent=indent + "  ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def simulation_lines(
    comparison: comparisons.SimulationComparison, history: results.ResultHistory
) -> Iterator[str]:
    """One simulation and the estimates beside it."""
    simulation = comparison.simulation
    labels = _labels(history)
    yield f"estimates against {labels[simulation]}"
    error = percent(simulation.expected_error)
    yield from wrapped(
        f"{_describe_scene(simulation)}, expected error {error} points", "  "
    )
    poses = history.poses
    order = np.argsort(-simulation.probability, kind="stable")[: text.MOST_POSES]
    yield from _table_with_shares(
        (Column("pose"), Column("group"), Column(labels[simulation], "%")),
        [
            (
                str(poses.index[k]),
                str(poses.group[k]),
                percent(simulation.probability[k]),
            )
            for k in order
        ],
        [
            (labels[estimate.prediction], estimate.prediction.probability[order])
            for estimate in comparison.estimates
        ],
    )
    yield ""
    yield from _test_lines(comparison.estimates, labels)


def count_lines(comparison: comparisons.CountComparison) -> Iterator[str]:
    """The counts of cameras, and the predictions beside them."""
    yield from _camera_lines(comparison.counts)
    history = comparison.history
    if history is None:
        yield from wrapped(f"not compared: {comparison.problem}", "  ")
        yield from _uncompared_table(comparison.counts)
        return
    labels = _labels(history)
    for prediction in history.predictions:
        if labels[prediction] != prediction.method or prediction.drops:
            yield from wrapped(
                f"{labels[prediction]}: {_describe_scene(prediction)}", "  "
            )
    yield from _counted_shares(comparison, history, labels)
    yield ""
    yield from _test_lines(comparison.predictions, labels)
    for prediction in history.foretold:
        gap = prediction.forecast(history.poses).describe_gap(comparison.count)
        if gap:
            yield from wrapped(f"note: {labels[prediction]}: {gap}", "  ")
    for remark in comparison.remarks:
        yield from wrapped(f"note: {remark}", "  ")
    error = history.leading.plate_error
    if math.isfinite(error):
        yield from wrapped(
            f"note: a real plate is expected to be off by some {percent(error)} "
            "points rms, however many drops are simulated",
            "  ",
        )


def _camera_lines(counts: camera_counts.CameraCounts) -> Iterator[str]:
    plate = ""
    if counts.plate:
        plate = f" on plate {text.shortened(text.printable(counts.plate), 40)}"
    total = counts.classified + counts.unclassified
    low, high = map(float, errors.jeffreys_interval(counts.unclassified, total))
    yield f"camera counts{plate}: {several(counts.classified, 'part')} in stable poses"
    yield (
        f"  {several(counts.messages, 'message')}, {utc(counts.begin)} to "
        f"{utc(counts.end)} UTC"
    )
    yield (
        f"  unclassified: {counts.unclassified} of {total}, "
        f"{percent(counts.unclassified_share)} % (90 % interval {interval(low, high)} "
        "%)"
    )


def _uncompared_table(counts: camera_counts.CameraCounts) -> list[str]:
    rows = zip(counts.index.astype(str), counts.count.astype(str), strict=True)
    return columns((Column("pose"), Column("counted")), islice(rows, text.MOST_POSES))


def _labels(history: results.ResultHistory) -> dict[results.Prediction, str]:
    """Short names of the predictions, with their scenes where there are several."""
    labels = {}
    for prediction in history.predictions:
        method = text.shortened(text.printable(prediction.method), 16)
        labels[prediction] = f"{method} {scene_number(history, prediction)}".rstrip()
    return labels


def scene_number(history: results.ResultHistory, prediction: results.Prediction) -> str:
    """Number of a prediction's scene; empty where it has none, or all have the same."""
    scenes = history.scenes
    if len(scenes) > 1 and prediction.scene in scenes:
        return f"#{scenes.index(prediction.scene) + 1}"
    return ""


def _describe_scene(prediction: results.Prediction) -> str:
    drops = f"{prediction.drops} drops" if prediction.drops else "an estimate"
    if math.isnan(prediction.drop_height):
        return drops
    return f"{drops}, {prediction.scene}"


def _table_with_shares(
    heads: Sequence[Column],
    rows: Sequence[Sequence[str]],
    shares: Sequence[LabelledShares],
) -> list[str]:
    """A table with as many columns of probabilities beside it as the width allows."""
    for column_count in range(len(shares), -1, -1):
        fitting = shares[:column_count]
        lines = columns(
            (*heads, *(Column(label, "%") for label, _ in fitting)),
            (
                (*row, *(percent(values[k]) for _, values in fitting))
                for k, row in enumerate(rows)
            ),
        )
        if max(map(len, lines)) <= text.WIDTH:
            break
    hidden = ", ".join(label for label, _ in shares[column_count:])
    if hidden:
        lines += wrapped(f"--json and --csv also list {hidden}", "  ")
    return lines


def _counted_shares(
    comparison: comparisons.CountComparison,
    history: results.ResultHistory,
    labels: dict[results.Prediction, str],
) -> Iterator[str]:
    """Counts by pose, and by group where groups have several poses."""
    poses = history.poses
    yield from _share_table(
        ("pose", "group"),
        (poses.index, poses.group),
        comparison.count,
        [
            (labels[prediction], prediction.probability)
            for prediction in history.predictions
        ],
    )
    groups, group_of_pose = np.unique(poses.group, return_inverse=True)
    if 1 < groups.size < poses.index.size:
        yield ""
        yield from _share_table(
            ("group", "poses"),
            (groups, np.bincount(group_of_pose)),
            np.bincount(group_of_pose, comparison.count).astype(np.int64),
            [
                (
                    labels[prediction],
                    np.bincount(group_of_pose, prediction.probability).astype(
                        np.float64
                    ),
                )
                for prediction in history.predictions
            ],
        )


def _share_table(
    names: Sequence[str],
    numbers: Sequence[Index],
    counts: Index,
    shares: Sequence[LabelledShares],
) -> list[str]:
    """Counts, the largest first, with their shares; probabilities beside them."""
    total = counts.sum()
    low, high = errors.jeffreys_interval(counts, total)
    order = np.argsort(-counts, kind="stable")[: text.MOST_POSES]
    return _table_with_shares(
        (
            *map(Column, names),
            Column("counted"),
            Column("share", "%"),
            Column("90 % interval", "%"),
        ),
        [
            (
                *(str(column[k]) for column in numbers),
                str(counts[k]),
                percent(counts[k] / total if total else math.nan),
                interval(low[k], high[k]),
            )
            for k in order
        ],
        [(label, values[order]) for label, values in shares],
    )


def _test_lines(
    predictions: Sequence[comparisons.Comparison], labels: dict[results.Prediction, str]
) -> Iterator[str]:
    """How far predictions are off, and whether chance explains it."""
    rows = []
    for comparison in predictions:
        by_pose = comparison.by_pose
        by_group = comparison.by_group
        pose = comparison.largest_pose
        rows.append(
            (
                labels[comparison.prediction],
                percent(comparison.rms),
                percent(comparison.largest),
                str(pose) if pose >= 0 else "-",
                "pose",
                *_test_cells(by_pose),
            )
        )
        if (by_group.bins, by_group.statistic) != (by_pose.bins, by_pose.statistic):
            rows.append(("", "", "", "", "group", *_test_cells(by_group)))
    yield from columns(
        (
            Column("against", left=True),
            Column("rms", "points"),
            Column("largest", "points"),
            Column("at pose"),
            Column("by", left=True),
            Column("chi-square"),
            Column("df"),
            Column("p"),
            Column("pooled"),
            Column("difference", left=True),
        ),
        rows,
    )
    for comparison in predictions:
        if comparison.unforeseen:
            label = labels[comparison.prediction]
            if comparison.prediction.counted:
                surprise = f"no drop of {label} came to"
            else:
                surprise = f"{label} gives the probability 0"
            yield from wrapped(
                f"note: {comparison.unforeseen} counted in poses that {surprise}", "  "
            )


def _test_cells(test: chi_square.ChiSquare) -> tuple[str, ...]:
    if test.has_too_few_counts:
        return "too few", "-", "-", str(test.pooled), "-"
    p_value = "-"
    verdict = "its error is not known"
    if not math.isnan(test.p_value):
        p_value = f"{test.p_value:.4f}" if test.p_value >= 1e-4 else "<0.0001"
        verdict = _verdict(test.p_value)
    return (
        f"{test.statistic:.2f}",
        str(test.degrees_of_freedom),
        p_value,
        str(test.pooled),
        verdict,
    )


def _verdict(p_value: float) -> str:
    if p_value >= WITHIN_CHANCE:
        return "within chance"
    if p_value >= BEYOND_CHANCE:
        return "doubtful"
    return "beyond chance"
