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

"""The report on bags: what was read, then part by part, and how results compare."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ....base import text
from ....base.text import Column, columns, interval, percent, several, utc
from ....core.records.notes import note_lines
from ...bags import bag_reader, comparisons, jobs, plain, results
from .bag_comparisons import count_lines, scene_number, simulation_lines, wrapped

MOST_RESULTS = 12
MOST_JOBS = 20
MOST_TIMES = 5  # at which a part was forgotten


def bag_report(analysis: comparisons.BagAnalysis) -> str:
    """The whole report."""
    lines = list(_contents_lines(analysis.contents))
    for part in analysis.parts:
        lines += ["", *_part_lines(part)]
    for stray in analysis.strays:
        name = stray.counts.part_id or stray.counts.part_digest[:12]
        lines += ["", _rule(f"{name}: camera counts alone"), *count_lines(stray)]
    return "\n".join(lines)


def _contents_lines(contents: bag_reader.BagContents) -> Iterator[str]:
    kinds = ", ".join(f"{count} {kind}" for kind, count in contents.messages.items())
    yield (
        f"{several(len(contents.bags), 'bag')}, "
        f"{several(len(contents.files), 'file')}, {utc(contents.begin)} to "
        f"{utc(contents.end)} UTC"
    )
    yield from wrapped(f"messages: {kinds}")
    for file in contents.files:
        if file.note:
            yield f"note: {text.printable(str(file.path))}"
            yield from wrapped(
                f"{file.note} ({several(file.messages, 'message')} read)", "  "
            )
    for note in contents.notes:
        yield from wrapped(f"note: {note}")


def _rule(title: str) -> str:
    return f"== {text.shortened(text.printable(title), text.WIDTH - 10)} ".ljust(
        text.WIDTH, "="
    )


def _part_lines(part: comparisons.PartAnalysis) -> Iterator[str]:
    record = part.record
    name = f"{record.part_id} (digest {record.part_digest[:12]}"
    if math.isfinite(record.radius):
        name += f", radius {text.millimetres(record.radius)} mm"
    yield _rule(f"{name})")
    for history, simulations in zip(record.histories, part.simulations, strict=True):
        yield from ("", *_pose_lines(history), "", *_result_lines(history))
        for simulation in simulations:
            yield from ("", *simulation_lines(simulation, history))
    if record.jobs:
        yield from ("", *_job_lines(record.jobs))
    if record.forgotten:
        times = ", ".join(map(utc, record.forgotten[:MOST_TIMES]))
        yield from ("", f"forgotten by the node: {times} UTC")
    log = record.drop_log
    if log.drops:
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
        for line in note_lines(record.warnings):
            yield from wrapped(line)


def _pose_lines(history: results.ResultHistory) -> Iterator[str]:
    leading = history.leading
    poses = history.poses
    groups = len(np.unique(poses.group))
    drops = ""
    if leading.drops:
        drops = f", {leading.drops} drops, {leading.unsettled} unsettled"
    yield from wrapped(
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
    hidden = order[text.MOST_POSES :]
    if hidden.size:
        share = leading.probability[hidden].sum()
        yield f"  ... and {hidden.size} more, {percent(share)} % together"


def _result_lines(history: results.ResultHistory) -> Iterator[str]:
    count = len(history.time)
    methods = ", ".join(dict.fromkeys(history.method.tolist()))
    yield from wrapped(
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
                _result_remarks(history, k),
            )
            for k in listed
        ),
    )
    if count > len(listed):
        yield f"  {count - len(listed)} more in between"
    if len(history.scenes) > 1:
        for number, scene in enumerate(history.scenes, start=1):
            yield from wrapped(f"#{number}: {scene}")


def _result_remarks(history: results.ResultHistory, k: int) -> str:
    """What is special about a result; its scene, where there are several."""
    remarks = []
    if not history.final[k]:
        remarks.append("interim")
    if not history.latched[k]:
        remarks.append("to a caller")
    scene = scene_number(history, history.predictions[history.prediction[k]])
    if scene:
        remarks.append(scene)
    return ", ".join(remarks)


def _job_lines(part_jobs: Sequence[jobs.Job]) -> Iterator[str]:
    counts = plain.job_counts(part_jobs)
    yield "drop simulations: " + ", ".join(
        f"{count} {name}" for name, count in counts.items()
    )
    listed = sorted(part_jobs, key=lambda job: not job.unfinished)[:MOST_JOBS]
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
        map(_job_cells, listed),
    )
    if len(part_jobs) > len(listed):
        yield f"  ... and {len(part_jobs) - len(listed)} more"
    for job in listed:
        if job.state == "failed" and job.message:
            yield from wrapped(f"{job.job_id}: {job.message}", "  ")


def _job_cells(job: jobs.Job) -> tuple[str, ...]:
    seconds = "-"
    if job.started and job.ended:
        seconds = f"{(job.ended - job.started) / 1e9:.1f}"
    return (
        text.ending(job.job_id, 22),
        "unfinished" if job.unfinished else job.state,
        utc(job.queued),
        seconds,
        str(job.drops_done),
        str(job.drops),
        f"{job.restitution:g}",
    )
