"""An analysis as plain values: what `bag --json` prints."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ...core.records.plain_values import UNITS, with_units, without_rounding
from ...node.recording import decoding
from . import comparisons as compared, jobs as simulated
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
    "restitution",
    "drop_height",
    "cluster_tolerance",
    "round_sides",
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


def as_dict(analysis: compared.BagAnalysis) -> Plain:
    """Everything under plain keys; times are seconds since 1970, NaN and infinity None."""
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
            "stray_counts": [_counts(one) for one in analysis.strays],
        },
        {**UNITS, **TIME_UNITS},
    )


def job_counts(jobs: Iterable[simulated.Job]) -> dict[str, int]:
    """How many jobs were accepted, and what became of them."""
    states = [job.state for job in jobs]
    return {
        "accepted": len(states),
        **{name: states.count(name) for name in simulated.TERMINAL},
        "unfinished": sum(name not in simulated.TERMINAL for name in states),
    }


def _fields(record: Any, names: Sequence[str]) -> Plain:
    values = {name: getattr(record, name) for name in names}
    return {
        name: value / decoding.SECOND if name in TIMES else value
        for name, value in values.items()
    }


def _rows(columns: Plain) -> list[Plain]:
    """A dict a row out of columns of equal length."""
    lists = {name: column.tolist() for name, column in columns.items()}
    return [
        dict(zip(lists, row, strict=True)) for row in zip(*lists.values(), strict=True)
    ]


def _part(part: compared.PartAnalysis) -> Plain:
    record = part.record
    return {
        **_fields(record, ("part_id", "part_digest", "radius", "plates", "warnings")),
        "forgotten": [time / decoding.SECOND for time in record.forgotten],
        "drop_log": _fields(
            record.drop_log, ("drops", "unsettled", "impacts", "seconds")
        ),
        "job_counts": job_counts(record.jobs),
        "jobs": [
            {
                **_fields(job, JOB),
                **{
                    name: getattr(job, name) / decoding.SECOND or None
                    for name in JOB_TIMES
                },
            }
            for job in record.jobs
        ],
        "numberings": [
            _history(history, simulations)
            for history, simulations in zip(
                record.histories, part.simulations, strict=True
            )
        ],
        "counts": [_counts(one) for one in part.counts],
    }


def _history(
    history: ResultHistory, simulations: Iterable[compared.SimulationComparison]
) -> Plain:
    results = {
        **{name: getattr(history, name) for name in RESULT},
        "scene": np.array(history.scene, dtype=np.str_),
    }
    return {
        **history.numbering._asdict(),
        "poses": [
            {**pose, "down": without_rounding(np.array(pose["down"]))}
            for pose in _rows({name: getattr(history.poses, name) for name in POSE})
        ],
        "predictions": [
            {
                **_fields(one, (*ABOUT, "scene")),
                "poses": _rows(
                    {
                        "index": history.poses.index,
                        **{name: getattr(one, name) for name in PREDICTED},
                    }
                ),
            }
            for one in history.predictions
        ],
        "results": _rows({**results, "time": history.time / decoding.SECOND}),
        "simulations": [
            {
                "simulation": history.predictions.index(one.simulation),
                "estimates": [
                    _comparison(each, history.predictions) for each in one.estimates
                ],
            }
            for one in simulations
        ],
    }


def _comparison(one: compared.Comparison, predictions: Sequence[Prediction]) -> Plain:
    tests = {
        name: {**asdict(test), "too_few": test.has_too_few_counts}
        for name, test in (("by_pose", one.by_pose), ("by_group", one.by_group))
    }
    return {
        "prediction": list(predictions).index(one.prediction),
        **_fields(one, ("rms", "largest", "largest_pose", "unforeseen")),
        **tests,
    }


def _counts(one: compared.CountComparison) -> Plain:
    counts = one.counts
    predictions = one.history.predictions if one.history else ()
    low, high = one.bounds
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
        "compared": not one.problem,
        **_fields(one, ("problem", "remarks")),
        "share": one.share,
        "share_low": low,
        "share_high": high,
        "predictions": [_comparison(each, predictions) for each in one.predictions],
    }
