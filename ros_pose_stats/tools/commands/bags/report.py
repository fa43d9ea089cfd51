"""The report on bags: what was read, then part by part, and comparisons of the results."""

import math
from collections.abc import Iterator, Sequence
from textwrap import wrap

import numpy as np
from numpy.typing import NDArray

from ....base import text
from ....base.text import Column, columns, interval, percent, several, utc
from ....core.statistics import chi_square, errors
from ...bags import bag_reader, comparisons, jobs as simulated, plain, results

MOST_RESULTS = 12
MOST_JOBS = 20


def bag_report(found: comparisons.BagAnalysis) -> str:
    """The whole report."""
    lines = list(_read(found.contents))
    for part in found.parts:
        lines += ["", *_part(part)]
    for stray in found.strays:
        lines += [
            "",
            _rule(
                f"{stray.counts.part_id or stray.counts.part_digest[:12]}: camera "
                "counts alone"
            ),
            *count_lines(stray),
        ]
    return "\n".join(lines)


def _read(contents: bag_reader.BagContents) -> Iterator[str]:
    kinds = ", ".join(f"{count} {kind}" for kind, count in contents.messages.items())
    yield (
        f"{several(len(contents.bags), 'bag')}, {several(len(contents.files), 'file')}, "
        f"{utc(contents.begin)} to {utc(contents.end)} UTC"
    )
    yield from _wrapped(f"messages: {kinds}")
    for file in contents.files:
        if file.note:
            yield f"note: {text.printable(str(file.path))}"
            yield from _wrapped(
                f"{file.note} ({several(file.messages, 'message')} read)", "  "
            )
    for note in contents.notes:
        yield from _wrapped(f"note: {note}")


def _wrapped(line: str, indent: str = "") -> list[str]:
    return wrap(
        text.printable(line),
        text.WIDTH,
        initial_indent=indent,
        subsequent_indent=indent + "  ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def _rule(title: str) -> str:
    return f"== {text.shortened(text.printable(title), text.WIDTH - 10)} ".ljust(
        text.WIDTH, "="
    )


def _part(part: comparisons.PartAnalysis) -> Iterator[str]:
    record = part.record
    radius = (
        f", radius {text.millimetres(record.radius)} mm"
        if math.isfinite(record.radius)
        else ""
    )
    yield _rule(f"{record.part_id} (digest {record.part_digest[:12]}{radius})")
    for history, simulations in zip(record.histories, part.simulations, strict=True):
        yield from ("", *_poses(history), "", *_results(history))
        for simulation in simulations:
            yield from ("", *simulation_lines(simulation, history))
    if record.jobs:
        yield from ("", *_jobs(record.jobs))
    if record.forgotten:
        yield from (
            "",
            f"forgotten by the node: {', '.join(map(utc, record.forgotten[:5]))} UTC",
        )
    if record.drop_log.drops:
        log = record.drop_log
        yield from (
            "",
            f"drops recorded one by one: {log.drops}, {log.unsettled} unsettled, on "
            f"average {log.impacts / log.drops:.1f} impacts and "
            f"{log.seconds / log.drops:.3g} s",
        )
    for counts in part.counts:
        yield from ("", *count_lines(counts))
    if record.warnings:
        yield ""
        for line in record.warnings:
            yield from _wrapped(line)


def _poses(history: results.ResultHistory) -> Iterator[str]:
    leading = history.leading
    poses = history.poses
    drops = (
        f", {leading.drops} drops, {leading.unsettled} unsettled"
        if leading.drops
        else ""
    )
    groups = len(np.unique(poses.group))
    yield from _wrapped(
        f"{several(len(poses.index), 'pose')} in {several(groups, 'group')} at "
        f"{history.numbering}, by {leading.method}{drops}, {leading.scene}"
    )
    order = np.argsort(-np.nan_to_num(leading.probability), kind="stable")
    yield from columns(
        (
            Column("pose"),
            Column("group"),
            Column("probability", "%"),
            Column("90 % interval", "%"),
            Column("height", "mm"),
            Column("barrier", "mm"),
            Column("topple", "deg"),
        ),
        (
            (
                str(poses.index[k]),
                str(poses.group[k]),
                percent(leading.probability[k]),
                interval(leading.probability_low[k], leading.probability_high[k]),
                text.millimetres(poses.height[k]),
                text.millimetres(poses.barrier[k]),
                text.degrees(poses.margin[k]),
            )
            for k in order[: text.MOST_POSES]
        ),
    )
    if len(order) > text.MOST_POSES:
        rest = leading.probability[order[text.MOST_POSES :]].sum()
        yield f"  ... and {len(order) - text.MOST_POSES} more, {percent(rest)} % together"


def _results(history: results.ResultHistory) -> Iterator[str]:
    count = len(history.time)
    methods = ", ".join(dict.fromkeys(history.method.tolist()))
    yield from _wrapped(
        f"{several(count, 'result')} by {methods}; the change is the largest of "
        "any probability since the result before"
    )
    listed = np.unique(
        np.linspace(0, count - 1, min(count, MOST_RESULTS)).round().astype(int)
    )
    change = history.largest_change
    yield from columns(
        (
            Column("result"),
            Column("time", "UTC", left=True),
            Column("method", left=True),
            Column("drops"),
            Column("error", "points"),
            Column("one pose", "points"),
            Column("change", "points"),
            Column("", left=True),
        ),
        (
            (
                str(k + 1),
                utc(int(history.time[k])),
                str(history.method[k]),
                str(history.drops[k] or "-"),
                percent(history.expected_error[k]),
                percent(history.largest_error[k]),
                percent(change[k]),
                _kind(history, k),
            )
            for k in listed
        ),
    )
    if count > len(listed):
        yield f"  {count - len(listed)} more in between"
    if len(history.scenes) > 1:
        for number, scene in enumerate(history.scenes, start=1):
            yield from _wrapped(f"#{number}: {scene}")


def _kind(history: results.ResultHistory, k: int) -> str:
    """Label of a result; it names the scene where there are several."""
    said = [] if history.final[k] else ["interim"]
    said += [] if history.latched[k] else ["to a caller"]
    scene = scene_name(history, history.predictions[history.prediction[k]])
    return ", ".join([*said, scene] if scene else said)


def _jobs(jobs: tuple[simulated.Job, ...]) -> Iterator[str]:
    counted = plain.job_counts(jobs)
    yield "drop simulations: " + ", ".join(
        f"{count} {name}" for name, count in counted.items()
    )
    listed = sorted(jobs, key=lambda job: not job.unfinished)[:MOST_JOBS]
    yield from columns(
        (
            Column("job", left=True),
            Column("state", left=True),
            Column("queued", "UTC", left=True),
            Column("took", "s"),
            Column("done", "drops"),
            Column("of", "drops"),
            Column("restitution"),
        ),
        (
            (
                text.ending(job.job_id, 22),
                "unfinished" if job.unfinished else job.state,
                utc(job.queued),
                f"{(job.ended - job.started) / 1e9:.1f}"
                if job.started and job.ended
                else "-",
                str(job.drops_done),
                str(job.drops),
                f"{job.restitution:g}",
            )
            for job in listed
        ),
    )
    if len(jobs) > len(listed):
        yield f"  ... and {len(jobs) - len(listed)} more"
    for job in listed:
        if job.state == "failed" and job.message:
            yield from _wrapped(f"{job.job_id}: {job.message}", "  ")


WITHIN_CHANCE = 0.05
BEYOND_CHANCE = 0.001


def simulation_lines(
    found: comparisons.SimulationComparison, history: results.ResultHistory
) -> Iterator[str]:
    """One simulation and the estimates beside it."""
    one = found.simulation
    labels = _labels(history)
    yield f"estimates against {labels[one]}"
    error = percent(one.expected_error)
    yield from _wrapped(f"{_scene(one)}, expected error {error} points", "  ")
    poses = history.poses
    order = np.argsort(-one.probability, kind="stable")[: text.MOST_POSES]
    yield from _beside(
        (Column("pose"), Column("group"), Column(labels[one], "%")),
        [
            (str(poses.index[k]), str(poses.group[k]), percent(one.probability[k]))
            for k in order
        ],
        [
            (labels[each.prediction], each.prediction.probability[order])
            for each in found.estimates
        ],
    )
    yield ""
    yield from _tests(found.estimates, labels)


def count_lines(found: comparisons.CountComparison) -> Iterator[str]:
    """The counts of cameras, and the predictions beside them."""
    counts = found.counts
    plate = (
        f" on plate {text.shortened(text.printable(counts.plate), 40)}"
        if counts.plate
        else ""
    )
    total = counts.classified + counts.unclassified
    low, high = map(float, errors.jeffreys_interval(counts.unclassified, total))
    yield f"camera counts{plate}: {several(counts.classified, 'part')} in stable poses"
    yield (
        f"  {several(counts.messages, 'message')}, {utc(counts.begin)} to {utc(counts.end)} "
        "UTC"
    )
    yield (
        f"  unclassified: {counts.unclassified} of {total}, "
        f"{percent(counts.unclassified_share)} % (90 % interval {interval(low, high)} %)"
    )
    history = found.history
    if history is None:
        yield from _wrapped(f"not compared: {found.problem}", "  ")
        yield from columns(
            (Column("pose"), Column("counted")),
            (
                (str(index), str(count))
                for index, count in zip(
                    counts.index[: text.MOST_POSES],
                    counts.count[: text.MOST_POSES],
                    strict=True,
                )
            ),
        )
        return
    labels = _labels(history)
    for one in history.predictions:
        if labels[one] != one.method or one.drops:
            yield from _wrapped(f"{labels[one]}: {_scene(one)}", "  ")
    yield from _counted(found, history, labels)
    yield ""
    yield from _tests(found.predictions, labels)
    for remark in found.remarks:
        yield from _wrapped(f"note: {remark}", "  ")
    error = history.leading.plate_error
    if math.isfinite(error):
        yield from _wrapped(
            f"note: a real plate is expected to be off by some {percent(error)} "
            "points rms, however many drops are simulated",
            "  ",
        )


def _labels(history: results.ResultHistory) -> dict[results.Prediction, str]:
    """Short names of the predictions, with their scenes where there are several."""
    return {
        one: (
            f"{text.shortened(text.printable(one.method), 16)} "
            f"{scene_name(history, one)}"
        ).rstrip()
        for one in history.predictions
    }


def scene_name(history: results.ResultHistory, one: results.Prediction) -> str:
    """Number of a prediction's scene; empty where it has none, or all have the same."""
    several_scenes = len(history.scenes) > 1 and one.scene in history.scenes
    return f"#{history.scenes.index(one.scene) + 1}" if several_scenes else ""


def _scene(one: results.Prediction) -> str:
    drops = f"{one.drops} drops" if one.drops else "an estimate"
    return drops if math.isnan(one.drop_height) else f"{drops}, {one.scene}"


def _beside(
    heads: Sequence[Column],
    rows: Sequence[Sequence[str]],
    others: Sequence[tuple[str, NDArray[np.float64]]],
) -> list[str]:
    """A table with as many columns of probabilities beside it as the width allows."""
    for shown in range(len(others), -1, -1):
        lines = columns(
            (*heads, *(Column(label, "%") for label, _ in others[:shown])),
            (
                (*row, *(percent(values[k]) for _, values in others[:shown]))
                for k, row in enumerate(rows)
            ),
        )
        if max(map(len, lines)) <= text.WIDTH:
            break
    hidden = ", ".join(label for label, _ in others[shown:])
    return lines + (
        _wrapped(f"--json and --csv also list {hidden}", "  ") if hidden else []
    )


def _counted(
    found: comparisons.CountComparison,
    history: results.ResultHistory,
    labels: dict[results.Prediction, str],
) -> Iterator[str]:
    """Counts by pose, and by group where groups have several poses."""
    poses = history.poses
    yield from _shares(
        ("pose", "group"),
        (poses.index, poses.group),
        found.count,
        [(labels[each], each.probability) for each in history.predictions],
    )
    groups, place = np.unique(poses.group, return_inverse=True)
    if 1 < groups.size < poses.index.size:
        yield ""
        yield from _shares(
            ("group", "poses"),
            (groups, np.bincount(place)),
            np.bincount(place, found.count).astype(np.int64),
            [
                (labels[each], np.bincount(place, each.probability).astype(np.float64))
                for each in history.predictions
            ],
        )


def _shares(
    names: Sequence[str],
    numbers: Sequence[NDArray[np.int64]],
    counts: NDArray[np.int64],
    others: Sequence[tuple[str, NDArray[np.float64]]],
) -> list[str]:
    """Counts, the largest first, with their shares; probabilities beside them."""
    total = counts.sum()
    low, high = errors.jeffreys_interval(counts, total)
    order = np.argsort(-counts, kind="stable")[: text.MOST_POSES]
    return _beside(
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
        [(label, values[order]) for label, values in others],
    )


def _tests(
    found: Sequence[comparisons.Comparison], labels: dict[results.Prediction, str]
) -> Iterator[str]:
    rows = []
    for one in found:
        of_pose = one.by_pose
        of_group = one.by_group
        about = (
            labels[one.prediction],
            percent(one.rms),
            percent(one.largest),
            str(one.largest_pose) if one.largest_pose >= 0 else "-",
        )
        rows.append((*about, "pose", *_test(of_pose)))
        if (of_group.bins, of_group.statistic) != (of_pose.bins, of_pose.statistic):
            rows.append(("", "", "", "", "group", *_test(of_group)))
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
    for one in found:
        if one.unforeseen:
            label = labels[one.prediction]
            yield from _wrapped(
                f"note: {one.unforeseen} counted in poses that "
                + (
                    f"no drop of {label} came to"
                    if one.prediction.counted
                    else f"{label} gives the probability 0"
                ),
                "  ",
            )


def _test(test: chi_square.ChiSquare) -> tuple[str, ...]:
    if test.too_few:
        return ("too few", "-", "-", str(test.pooled), "-")
    p = test.p_value
    if math.isnan(p):
        return (
            f"{test.statistic:.2f}",
            str(test.degrees_of_freedom),
            "-",
            str(test.pooled),
            "its error is not known",
        )
    verdict = (
        "within chance"
        if p >= WITHIN_CHANCE
        else "doubtful"
        if p >= BEYOND_CHANCE
        else "beyond chance"
    )
    return (
        f"{test.statistic:.2f}",
        str(test.degrees_of_freedom),
        f"{p:.4f}" if p >= 1e-4 else "<0.0001",
        str(test.pooled),
        verdict,
    )
