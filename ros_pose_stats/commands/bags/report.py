"""The report on bags: what was read, then part by part."""

import math
from collections.abc import Iterator
from textwrap import wrap

import numpy as np

from ... import text
from ...recording.analysis import BagAnalysis, BagContents, Job, PartAnalysis, ResultHistory, plain
from ...text import Column, columns, interval, percent, several, utc
from .comparisons import count_lines, scene_name, simulation_lines

MOST_RESULTS, MOST_JOBS = 12, 20


def bag_report(found: BagAnalysis) -> str:
    """The whole report."""
    lines = list(_read(found.contents))
    for part in found.parts:
        lines += ["", *_part(part)]
    for stray in found.strays:
        lines += ["", _rule(f"{stray.counts.part_id or stray.counts.part_digest[:12]}: camera "
                            "counts alone"), *count_lines(stray)]
    return "\n".join(lines)


def _read(contents: BagContents) -> Iterator[str]:
    kinds = ", ".join(f"{count} {kind}" for kind, count in contents.messages.items())
    yield (f"{several(len(contents.bags), 'bag')}, {several(len(contents.files), 'file')}, "
           f"{utc(contents.begin)} to {utc(contents.end)} UTC")
    yield from _wrapped(f"messages: {kinds}")
    for file in contents.files:
        if file.note:
            yield f"note: {text.printable(str(file.path))}"
            yield from _wrapped(f"{file.note} ({several(file.messages, 'message')} read)", "  ")
    for note in contents.notes:
        yield from _wrapped(f"note: {note}")


def _wrapped(line: str, indent: str = "") -> list[str]:
    return wrap(text.printable(line), text.WIDTH, initial_indent=indent,
                subsequent_indent=indent + "  ", break_long_words=False, break_on_hyphens=False)


def _rule(title: str) -> str:
    return f"== {text.shortened(text.printable(title), text.WIDTH - 10)} ".ljust(text.WIDTH, "=")


def _part(part: PartAnalysis) -> Iterator[str]:
    record = part.record
    radius = (f", radius {text.millimetres(record.radius)} mm"
              if math.isfinite(record.radius) else "")
    yield _rule(f"{record.part_id} (digest {record.part_digest[:12]}{radius})")
    for history, simulations in zip(record.histories, part.simulations, strict=True):
        yield from ("", *_poses(history), "", *_results(history))
        for simulation in simulations:
            yield from ("", *simulation_lines(simulation, history))
    if record.jobs:
        yield from ("", *_jobs(record.jobs))
    if record.forgotten:
        yield from ("", f"forgotten by the node: {', '.join(map(utc, record.forgotten[:5]))} UTC")
    if record.drop_log.drops:
        log = record.drop_log
        yield from ("", f"drops recorded one by one: {log.drops}, {log.unsettled} unsettled, on "
                    f"average {log.impacts / log.drops:.1f} impacts and "
                    f"{log.seconds / log.drops:.3g} s")
    for counts in part.counts:
        yield from ("", *count_lines(counts))
    if record.warnings:
        yield ""
        for line in record.warnings:
            yield from _wrapped(line)


def _poses(history: ResultHistory) -> Iterator[str]:
    leading, poses = history.leading, history.poses
    drops = f", {leading.drops} drops, {leading.unsettled} unsettled" if leading.drops else ""
    groups = len(np.unique(poses.group))
    yield from _wrapped(f"{several(len(poses.index), 'pose')} in {several(groups, 'group')} at "
                        f"{history.numbering}, by {leading.method}{drops}")
    order = np.argsort(-np.nan_to_num(leading.probability), kind="stable")
    yield from columns(
        (Column("pose"), Column("group"), Column("probability", "%"),
         Column("90 % interval", "%"), Column("height", "mm"), Column("barrier", "mm"),
         Column("margin", "deg")),
        ((str(poses.index[k]), str(poses.group[k]), percent(leading.probability[k]),
          interval(leading.probability_low[k], leading.probability_high[k]),
          text.millimetres(poses.height[k]), text.millimetres(poses.barrier[k]),
          text.degrees(poses.margin[k]))
         for k in order[:text.MOST_POSES]))
    if len(order) > text.MOST_POSES:
        rest = leading.probability[order[text.MOST_POSES:]].sum()
        yield f"  ... and {len(order) - text.MOST_POSES} more, {percent(rest)} % together"


def _results(history: ResultHistory) -> Iterator[str]:
    count = len(history.time)
    methods = ", ".join(dict.fromkeys(history.method.tolist()))
    yield from _wrapped(f"{several(count, 'result')} by {methods}; the change is the largest of "
                        "any probability since the result before")
    listed = np.unique(np.linspace(0, count - 1, min(count, MOST_RESULTS)).round().astype(int))
    change = history.largest_change
    yield from columns(
        (Column("result"), Column("time", "UTC", left=True), Column("method", left=True),
         Column("drops"), Column("error", "points"),
         Column("one pose", "points"), Column("change", "points"),
         Column("", left=True)),
        ((str(k + 1), utc(int(history.time[k])), str(history.method[k]),
          str(history.drops[k] or "-"), percent(history.expected_error[k]),
          percent(history.largest_error[k]), percent(change[k]),
          _kind(history, k)) for k in listed))
    if count > len(listed):
        yield f"  {count - len(listed)} more in between"
    if len(history.scenes) > 1:
        for number, scene in enumerate(history.scenes, start=1):
            yield from _wrapped(f"#{number}: {scene}")


def _kind(history: ResultHistory, k: int) -> str:
    """Label of a result; it names the scene where there are several."""
    said = [] if history.final[k] else ["interim"]
    said += [] if history.latched[k] else ["to a caller"]
    scene = scene_name(history, history.predictions[history.prediction[k]])
    return ", ".join([*said, scene] if scene else said)


def _jobs(jobs: tuple[Job, ...]) -> Iterator[str]:
    counted = plain.job_counts(jobs)
    yield "drop simulations: " + ", ".join(f"{count} {name}" for name, count in counted.items())
    listed = sorted(jobs, key=lambda job: not job.unfinished)[:MOST_JOBS]
    yield from columns(
        (Column("job", left=True), Column("state", left=True), Column("queued", "UTC", left=True),
         Column("took", "s"), Column("done", "drops"), Column("of", "drops"),
         Column("restitution")),
        ((text.ending(job.job_id, 22), "unfinished" if job.unfinished else job.state,
          utc(job.queued), _took(job), str(job.drops_done), str(job.drops),
          f"{job.restitution:g}") for job in listed))
    if len(jobs) > len(listed):
        yield f"  ... and {len(jobs) - len(listed)} more"
    for job in listed:
        if job.state == "failed" and job.message:
            yield from _wrapped(f"{job.job_id}: {job.message}", "  ")


def _took(job: Job) -> str:
    return f"{(job.ended - job.started) / 1e9:.1f}" if job.started and job.ended else "-"
