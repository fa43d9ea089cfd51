"""An analysis of bags as CSV files, for spreadsheets."""

from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np

from ... import files, text
from ...recording.analysis.comparisons import BagAnalysis, PartAnalysis
from ...recording.analysis.results import Prediction, ResultHistory
from ...records.scene import Numbering

Rows = Iterator[Sequence[Any]]

PART = ("part_id", "part_digest", *Numbering._fields)
PREDICTION = ("method", "restitution", "drop_height_m", "drops")
HEADS: dict[str, tuple[str, ...]] = {
    "files": ("bag", "file", "state", "note", "messages"),
    "poses": (*PART, *PREDICTION, "pose", "group", "height_m", "top_m", "margin_rad", "barrier_m",
              "spread_rad", "down_x", "down_y", "down_z", "probability", "probability_low",
              "probability_high", "standard_error", "count", "prediction"),
    "answers": (*PART, "time_utc", "method", "restitution", "drop_height_m", "drops", "unsettled",
                "expected_error", "largest_error", "largest_change", "final", "latched", "scene",
                "result", "prediction", "pose", "probability"),
    "jobs": ("part_id", "part_digest", "job_id", "state", "refinement", "queued_utc",
             "started_utc", "ended_utc", "drops_done", "drops", "seed", "restitution",
             "drop_height_m", *Numbering._fields, "target_error", "max_seconds_s",
             "message"),
    "counts": (*PART, "plate", "drop_height_m", "begin_utc", "end_utc", "pose", "count", "share",
               "share_low", "share_high", "not_compared"),
    "comparison": (*PART, "counts_of", "counted", *PREDICTION, "rms", "largest_difference",
                   "largest_pose", "by", "chi_square", "degrees_of_freedom", "p_value", "bins",
                   "pooled", "counted_where_probability_0"),
}
"""Columns of each file. Probabilities, shares and errors are fractions."""


def write_csv(found: BagAnalysis, folder: Path) -> list[Path]:
    """Write all files, each at once under its name; return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, heads in HEADS.items():
        path = folder / f"{name}.csv"
        files.replace_file(path, "".join(text.csv_lines(heads, ROWS[name](found))).encode())
        written.append(path)
    return written


def _utc(nanoseconds: int) -> str:
    if not nanoseconds:
        return ""
    second = datetime.fromtimestamp(nanoseconds // text.SECOND, timezone.utc)
    return f"{second:%Y-%m-%dT%H:%M:%S}.{nanoseconds % text.SECOND:09d}Z"


def _columns(*columns: Any) -> Rows:
    """Rows of plain values out of arrays of equal length."""
    return zip(*(column.tolist() for column in columns), strict=True)


def _name(part: PartAnalysis, history: ResultHistory) -> tuple[Any, ...]:
    return part.record.part_id, part.record.part_digest, *history.numbering


def _about(one: Prediction) -> tuple[Any, ...]:
    return one.method, one.restitution, one.drop_height, one.drops


def _histories(found: BagAnalysis) -> Iterator[tuple[ResultHistory, tuple[Any, ...]]]:
    """Yield every numbering of every part, with the first cells of its rows."""
    for part in found.parts:
        for history in part.record.histories:
            yield history, _name(part, history)


def _files(found: BagAnalysis) -> Rows:
    for file in found.contents.files:
        yield file.bag, file.path, file.state, file.note, file.messages


def _poses(found: BagAnalysis) -> Rows:
    for history, head in _histories(found):
        poses = history.poses
        for number, one in enumerate(history.predictions):
            for row in _columns(poses.index, poses.group, poses.height, poses.top, poses.margin,
                                poses.barrier, poses.spread, *poses.down.T, one.probability,
                                one.probability_low, one.probability_high, one.standard_error,
                                one.count):
                yield *head, *_about(one), *row, number


def _answers(found: BagAnalysis) -> Rows:
    for history, head in _histories(found):
        poses = history.poses.index.tolist()
        rows = _columns(history.time, history.method, history.restitution, history.drop_height,
                        history.drops, history.unsettled, history.expected_error,
                        history.largest_error, history.largest_change, history.final,
                        history.latched, np.array(history.scene), history.prediction,
                        history.probability)
        for number, (time, *row, prediction, probabilities) in enumerate(rows, start=1):
            for pose, probability in zip(poses, probabilities, strict=True):
                yield *head, _utc(time), *row, number, prediction, pose, probability


def _jobs(found: BagAnalysis) -> Rows:
    for part in found.parts:
        for job in part.record.jobs:
            yield (part.record.part_id, part.record.part_digest, job.job_id, job.state,
                   job.refinement, _utc(job.queued), _utc(job.started), _utc(job.ended),
                   job.drops_done, job.drops, job.seed, job.restitution, job.drop_height,
                   job.cluster_tolerance, job.round_sides, job.target_error, job.max_seconds,
                   job.message)


def _counts(found: BagAnalysis) -> Rows:
    for one in (*(each for part in found.parts for each in part.counts), *found.strays):
        of = one.counts
        head = (of.part_id, of.part_digest, *of.numbering, of.plate, of.drop_height,
                _utc(of.begin), _utc(of.end))
        if one.history is None:
            for pose, count in _columns(of.index, of.count):
                yield *head, pose, count, "", "", "", one.problem
        else:
            for row in _columns(one.history.poses.index, one.count, one.share, *one.bounds):
                yield *head, *row, one.problem
        yield *head, "unclassified", of.unclassified, of.unclassified_share, "", "", one.problem


def _comparison(found: BagAnalysis) -> Rows:
    for part in found.parts:
        compared = [("simulation", int(one.simulation.count.sum()), each, history)
                    for history, simulations in zip(part.record.histories, part.simulations,
                                                    strict=True)
                    for one in simulations for each in one.estimates]
        compared += [("camera", counts.counts.classified, each, counts.history)
                     for counts in part.counts if counts.history for each in counts.predictions]
        for of, counted, one, history in compared:
            for by, test in (("pose", one.by_pose), ("group", one.by_group)):
                yield (*_name(part, history), of, counted, *_about(one.prediction), one.rms,
                       one.largest, one.largest_pose, by, test.statistic,
                       test.degrees_of_freedom, test.p_value, test.bins, test.pooled,
                       one.unforeseen)


ROWS = {"files": _files, "poses": _poses, "answers": _answers, "jobs": _jobs, "counts": _counts,
        "comparison": _comparison}
