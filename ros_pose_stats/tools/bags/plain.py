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

"""An analysis as plain values: what `bag --json` prints."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ...base.text import SECOND
from ...core.records.plain_values import UNITS, with_units, without_rounding
from ...core.records.scene import SCENE_FIELDS
from .comparisons import (
    BagAnalysis,
    Comparison,
    CountComparison,
    PartAnalysis,
    SimulationComparison,
)
from .jobs import TERMINAL, Job
from .results import ABOUT, POSE, PREDICTED, Prediction, ResultHistory

TIME_UNITS = dict.fromkeys(
    ("begin", "end", "time", "queued", "started", "ended", "forgotten"), "s since 1970"
)
Plain = dict[str, Any]
TIMES = ("begin", "end", "time")
JOB = (
    "job_id",
    "state",
    "unfinished",
    "refinement",
    "drops",
    "drops_done",
    "seed",
    *SCENE_FIELDS,
    "target_error",
    "max_seconds",
    "message",
)
JOB_TIMES = ("queued", "started", "ended")
RESULT = (
    "time",
    "method",
    "restitution",
    "drop_height",
    "drops",
    "unsettled",
    "expected_error",
    "largest_error",
    "largest_change",
    "final",
    "latched",
)


def as_dict(analysis: BagAnalysis) -> Plain:
    """All under plain keys; times in seconds since 1970, NaN and infinity None."""
    contents = analysis.contents
    return with_units(
        {
            "bags": contents.bags,
            "files": [
                _fields(file, ("bag", "path", "state", "note", "messages"))
                for file in contents.files
            ],
            "messages": contents.messages,
            **_fields(contents, ("begin", "end", "notes")),
            "parts": [_part(part) for part in analysis.parts],
            "stray_counts": [_counts(stray) for stray in analysis.strays],
        },
        {**UNITS, **TIME_UNITS},
    )


def job_counts(jobs: Iterable[Job]) -> dict[str, int]:
    """How many jobs were accepted, and what became of them."""
    states = [job.state for job in jobs]
    return {
        "accepted": len(states),
        **{name: states.count(name) for name in TERMINAL},
        "unfinished": sum(name not in TERMINAL for name in states),
    }


def _fields(record: Any, names: Sequence[str]) -> Plain:
    values = {name: getattr(record, name) for name in names}
    return {
        name: value / SECOND if name in TIMES else value
        for name, value in values.items()
    }


def _rows(columns: Plain) -> list[Plain]:
    """A dict a row out of columns of equal length."""
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]


def _part(part: PartAnalysis) -> Plain:
    record = part.record
    return {
        **_fields(record, ("part_id", "part_digest", "radius", "plates", "warnings")),
        "forgotten": [time / SECOND for time in record.forgotten],
        "drop_log": _fields(
            record.drop_log, ("drops", "unsettled", "impacts", "seconds")
        ),
        "job_counts": job_counts(record.jobs),
        "jobs": [_job(job) for job in record.jobs],
        "numberings": [
            _history(history, simulations)
            for history, simulations in zip(
                record.histories, part.simulations, strict=True
            )
        ],
        "counts": [_counts(comparison) for comparison in part.counts],
    }


def _job(job: Job) -> Plain:
    # A time of 0 was not recorded.
    times = {name: getattr(job, name) / SECOND or None for name in JOB_TIMES}
    return {**_fields(job, JOB), **times}


def _history(
    history: ResultHistory, simulations: Iterable[SimulationComparison]
) -> Plain:
    poses = _rows({name: getattr(history.poses, name) for name in POSE})
    for pose in poses:
        pose["down"] = without_rounding(np.array(pose["down"]))
    columns = {name: getattr(history, name) for name in RESULT}
    columns["time"] = history.time / SECOND
    columns["scene"] = np.array(history.scene, dtype=np.str_)
    return {
        **history.numbering._asdict(),
        "poses": poses,
        "predictions": [
            _prediction(prediction, history) for prediction in history.predictions
        ],
        "results": _rows(columns),
        "simulations": [
            {
                "simulation": history.predictions.index(comparison.simulation),
                "estimates": [
                    _comparison(estimate, history.predictions)
                    for estimate in comparison.estimates
                ],
            }
            for comparison in simulations
        ],
    }


def _prediction(prediction: Prediction, history: ResultHistory) -> Plain:
    shares = {name: getattr(prediction, name) for name in PREDICTED}
    return {
        **_fields(prediction, (*ABOUT, "scene")),
        "poses": _rows({"index": history.poses.index, **shares}),
    }


def _comparison(comparison: Comparison, predictions: Sequence[Prediction]) -> Plain:
    by_pose = comparison.by_pose
    by_group = comparison.by_group
    return {
        "prediction": list(predictions).index(comparison.prediction),
        **_fields(comparison, ("rms", "largest", "largest_pose", "unforeseen")),
        "by_pose": {**asdict(by_pose), "too_few": by_pose.has_too_few_counts},
        "by_group": {**asdict(by_group), "too_few": by_group.has_too_few_counts},
    }


def _counts(comparison: CountComparison) -> Plain:
    counts = comparison.counts
    predictions = comparison.history.predictions if comparison.history else ()
    low, high = comparison.bounds
    return {
        **_fields(counts, ("part_id", "part_digest")),
        **counts.numbering._asdict(),
        **_fields(
            counts,
            (
                "plate",
                "drop_height",
                "messages",
                "begin",
                "end",
                "index",
                "count",
                "unclassified",
            ),
        ),
        "unclassified_share": counts.unclassified_share,
        "compared": not comparison.problem,
        **_fields(comparison, ("problem", "remarks")),
        "share": comparison.share,
        "share_low": low,
        "share_high": high,
        "predictions": [
            _comparison(prediction, predictions)
            for prediction in comparison.predictions
        ],
    }
