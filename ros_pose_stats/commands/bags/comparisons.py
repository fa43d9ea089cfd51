"""Comparisons as text: estimates with simulations, and predictions with the counts of cameras."""

import math
from collections.abc import Iterator, Sequence
from textwrap import wrap

import numpy as np
from numpy.typing import NDArray

from ... import text
from ...recording.analysis import (
    Comparison,
    CountComparison,
    Prediction,
    ResultHistory,
    SimulationComparison,
)
from ...statistics import chi_square, errors
from ...text import Column, columns, interval, percent, several, utc

WITHIN_CHANCE, BEYOND_CHANCE = 0.05, 0.001


def simulation_lines(found: SimulationComparison, history: ResultHistory) -> Iterator[str]:
    """One simulation and the estimates beside it."""
    one, labels = found.simulation, _labels(history)
    yield f"estimates against {labels[one]}"
    yield from _wrapped(f"{_scene(one)}, expected error {percent(one.expected_error)} points")
    poses = history.poses
    order = np.argsort(-one.probability, kind="stable")[:text.MOST_POSES]
    yield from _beside(
        (Column("pose"), Column("group"), Column(labels[one], "%")),
        [(str(poses.index[k]), str(poses.group[k]), percent(one.probability[k])) for k in order],
        [(labels[each.prediction], each.prediction.probability[order])
         for each in found.estimates])
    yield ""
    yield from _tests(found.estimates, labels)


def count_lines(found: CountComparison) -> Iterator[str]:
    """The counts of cameras, and the predictions beside them."""
    counts = found.counts
    plate = f" on plate {text.shortened(text.printable(counts.plate), 40)}" if counts.plate else ""
    total = counts.classified + counts.unclassified
    low, high = map(float, errors.jeffreys_interval(counts.unclassified, total))
    yield f"camera counts{plate}: {several(counts.classified, 'part')} in stable poses"
    yield (f"  {several(counts.messages, 'message')}, {utc(counts.begin)} to {utc(counts.end)} "
           "UTC")
    yield (f"  unclassified: {counts.unclassified} of {total}, "
           f"{percent(counts.unclassified_share)} % (90 % interval {interval(low, high)} %)")
    history = found.history
    if history is None:
        yield from _wrapped(f"not compared: {found.problem}")
        yield from columns((Column("pose"), Column("counted")), (
            (str(index), str(count)) for index, count
            in zip(counts.index[:text.MOST_POSES], counts.count[:text.MOST_POSES], strict=True)))
        return
    labels = _labels(history)
    for one in history.predictions:
        if labels[one] != one.method or one.drops:
            yield from _wrapped(f"{labels[one]}: {_scene(one)}")
    yield from _counted(found, history, labels)
    yield ""
    yield from _tests(found.predictions, labels)
    for remark in found.remarks:
        yield from _wrapped(f"note: {remark}")
    error = history.leading.plate_error
    if math.isfinite(error):
        yield from _wrapped(f"note: a real plate is expected to be off by some {percent(error)} "
                            "points rms, however many drops are simulated")


def _wrapped(line: str) -> list[str]:
    return wrap(text.printable(line), text.WIDTH, initial_indent="  ", subsequent_indent="    ")


def _labels(history: ResultHistory) -> dict[Prediction, str]:
    """Short names of the predictions, with their scenes where there are several."""
    return {one: (f"{text.shortened(text.printable(one.method), 16)} "
                  f"{scene_name(history, one)}").rstrip() for one in history.predictions}


def scene_name(history: ResultHistory, one: Prediction) -> str:
    """Number of a prediction's scene; empty where it has none, or all have the same."""
    several_scenes = len(history.scenes) > 1 and one.scene in history.scenes
    return f"#{history.scenes.index(one.scene) + 1}" if several_scenes else ""


def _scene(one: Prediction) -> str:
    drops = f"{one.drops} drops" if one.drops else "an estimate"
    return drops if math.isnan(one.drop_height) else f"{drops}, {one.scene}"


def _beside(heads: Sequence[Column], rows: Sequence[Sequence[str]],
            others: Sequence[tuple[str, NDArray[np.float64]]]) -> list[str]:
    """A table with as many columns of probabilities beside it as the width allows."""
    for shown in range(len(others), -1, -1):
        lines = columns(
            (*heads, *(Column(label, "%") for label, _ in others[:shown])),
            ((*row, *(percent(values[k]) for _, values in others[:shown]))
             for k, row in enumerate(rows)))
        if max(map(len, lines)) <= text.WIDTH:
            break
    hidden = ", ".join(label for label, _ in others[shown:])
    return [*lines, *(_wrapped(f"--json and --csv also list {hidden}") if hidden else [])]


def _counted(found: CountComparison, history: ResultHistory,
             labels: dict[Prediction, str]) -> Iterator[str]:
    """Counts by pose, and by group where groups have several poses."""
    poses = history.poses
    yield from _shares(
        ("pose", "group"), (poses.index, poses.group), found.count,
        [(labels[each], each.probability) for each in history.predictions])
    groups, place = np.unique(poses.group, return_inverse=True)
    if 1 < groups.size < poses.index.size:
        yield ""
        yield from _shares(
            ("group", "poses"), (groups, np.bincount(place)),
            np.bincount(place, found.count).astype(np.int64),
            [(labels[each], np.bincount(place, each.probability).astype(np.float64))
             for each in history.predictions])


def _shares(names: Sequence[str], numbers: Sequence[NDArray[np.int64]], counts: NDArray[np.int64],
            others: Sequence[tuple[str, NDArray[np.float64]]]) -> list[str]:
    """Counts, the largest first, with their shares; probabilities beside them."""
    total = counts.sum()
    low, high = errors.jeffreys_interval(counts, total)
    order = np.argsort(-counts, kind="stable")[:text.MOST_POSES]
    return _beside(
        (*map(Column, names), Column("counted"), Column("share", "%"),
         Column("90 % interval", "%")),
        [(*(str(column[k]) for column in numbers), str(counts[k]),
          percent(counts[k] / total if total else math.nan), interval(low[k], high[k]))
         for k in order], [(label, values[order]) for label, values in others])


def _tests(found: Sequence[Comparison], labels: dict[Prediction, str]) -> Iterator[str]:
    rows = []
    for one in found:
        of_pose, of_group = one.by_pose, one.by_group
        about = (labels[one.prediction], percent(one.rms), percent(one.largest),
                 str(one.largest_pose) if one.largest_pose >= 0 else "-")
        rows.append((*about, "pose", *_test(of_pose)))
        if (of_group.bins, of_group.statistic) != (of_pose.bins, of_pose.statistic):
            rows.append(("", "", "", "", "group", *_test(of_group)))
    yield from columns(
        (Column("against", left=True), Column("rms", "points"), Column("largest", "points"),
         Column("at pose"), Column("by", left=True), Column("chi-square"), Column("df"),
         Column("p"), Column("pooled"), Column("difference", left=True)), rows)
    for one in found:
        if one.unforeseen:
            label = labels[one.prediction]
            yield from _wrapped(f"note: {one.unforeseen} counted in poses that " + (
                f"no drop of {label} came to" if one.prediction.counted
                else f"{label} gives the probability 0"))


def _test(test: chi_square.ChiSquare) -> tuple[str, ...]:
    if test.too_few:
        return ("too few", "-", "-", str(test.pooled), "-")
    p = test.p_value
    if math.isnan(p):
        return (f"{test.statistic:.2f}", str(test.degrees_of_freedom), "-", str(test.pooled),
                "its error is not known")
    verdict = ("within chance" if p >= WITHIN_CHANCE else
               "doubtful" if p >= BEYOND_CHANCE else "beyond chance")
    return (f"{test.statistic:.2f}", str(test.degrees_of_freedom),
            f"{p:.4f}" if p >= 1e-4 else "<0.0001", str(test.pooled), verdict)
