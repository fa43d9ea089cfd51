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

"""The tables of an analysis of bags as CSV files."""

from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
from itertools import chain
from pathlib import Path
from typing import Any

from ....base import files, text
from ....core.records.scene import SCENE_FIELDS, Numbering
from ...bags.comparisons import BagAnalysis, Comparison, CountComparison, PartAnalysis
from ...bags.results import ResultHistory

Rows = Iterator[Sequence[Any]]

PART = f"part_id part_digest {' '.join(Numbering._fields)}"
SCENE = "method restitution drop_height drops"
SHAPE = "index group height top margin barrier spread"
SHARES = "probability probability_low probability_high standard_error count"
RESULT = (
    f"time {SCENE} unsettled expected_error largest_error largest_change final latched"
)
JOB = (
    "job_id state refinement queued started ended drops_done drops seed "
    f"{' '.join(SCENE_FIELDS)} target_error max_seconds message"
)
TEST = "statistic degrees_of_freedom p_value bins pooled"
VALUES = {
    "files": "bag path state note messages",
    "poses": f"{PART} {SCENE} {SHAPE} down_x down_y down_z {SHARES} prediction",
    "answers": f"{PART} {RESULT} scene result prediction index probability",
    "jobs": f"part_id part_digest {JOB}",
    "counts": f"{PART} plate drop_height begin end index count share share_low "
    "share_high problem",
    "comparison": f"{PART} counts_of counted {SCENE} rms largest largest_pose by "
    f"{TEST} unforeseen",
}
"""Of the rows of each file. Probabilities, shares and errors are fractions."""

TIMES = ("time", "begin", "end", "queued", "started", "ended")
COLUMNS = {
    **{name: f"{name}_m" for name in ("drop_height", "height", "top", "barrier")},
    **{name: f"{name}_rad" for name in ("margin", "spread")},
    **{name: f"{name}_utc" for name in TIMES},
    "max_seconds": "max_seconds_s",
    "path": "file",
    "index": "pose",
    "problem": "not_compared",
    "largest": "largest_difference",
    "statistic": "chi_square",
    "unforeseen": "counted_where_probability_0",
}
"""Of values whose column has another name."""


def write_tables(analysis: BagAnalysis, folder: Path) -> list[Path]:
    """Write all files or none; return their paths."""

    def write(new_folder: Path) -> None:
        for table, values in VALUES.items():
            heads = [COLUMNS.get(name, name) for name in values.split()]
            with (new_folder / f"{table}.csv").open(
                "w", encoding="utf-8", errors="replace"
            ) as file:
                file.writelines(text.csv_lines(heads, ROWS[table](analysis)))

    return files.write_whole(folder, write)


def _utc(nanoseconds: int) -> str:
    if not nanoseconds:
        return ""
    second = datetime.fromtimestamp(nanoseconds // text.SECOND, timezone.utc)
    return f"{second:%Y-%m-%dT%H:%M:%S}.{nanoseconds % text.SECOND:09d}Z"


def _rows(*columns: Any) -> Rows:
    """Rows of plain values out of arrays of equal length."""
    return zip(*(column.tolist() for column in columns), strict=True)


def _values(record: Any, names: str) -> list[Any]:
    return [getattr(record, name) for name in names.split()]


def _part_cells(part: PartAnalysis, history: ResultHistory) -> tuple[Any, ...]:
    return part.record.part_id, part.record.part_digest, *history.numbering


def _histories(
    analysis: BagAnalysis,
) -> Iterator[tuple[ResultHistory, tuple[Any, ...]]]:
    """Yield every numbering of every part, with the first cells of its rows."""
    for part in analysis.parts:
        for history in part.record.histories:
            yield history, _part_cells(part, history)


def _file_rows(analysis: BagAnalysis) -> Rows:
    for file in analysis.contents.files:
        yield [str(value) for value in _values(file, VALUES["files"])]


def _pose_rows(analysis: BagAnalysis) -> Rows:
    for history, part_cells in _histories(analysis):
        poses = history.poses
        for number, prediction in enumerate(history.predictions):
            scene_cells = _values(prediction, SCENE)
            for row in _rows(
                *_values(poses, SHAPE), *poses.down.T, *_values(prediction, SHARES)
            ):
                yield *part_cells, *scene_cells, *row, number


def _answer_rows(analysis: BagAnalysis) -> Rows:
    for history, part_cells in _histories(analysis):
        poses = history.poses.index.tolist()
        rows = _rows(*_values(history, f"{RESULT} prediction probability"))
        for number, (row, scene) in enumerate(
            zip(rows, history.scene, strict=True), start=1
        ):
            time, *result_cells, prediction, probabilities = row
            cells = [*part_cells, _utc(time), *result_cells, scene, number, prediction]
            for pose, probability in zip(poses, probabilities, strict=True):
                yield *cells, pose, probability


def _job_rows(analysis: BagAnalysis) -> Rows:
    for part in analysis.parts:
        for job in part.record.jobs:
            values = {name: getattr(job, name) for name in JOB.split()}
            for name in values.keys() & set(TIMES):
                values[name] = _utc(values[name])
            yield part.record.part_id, part.record.part_digest, *values.values()


def _count_rows(analysis: BagAnalysis) -> Rows:
    of_parts = chain.from_iterable(part.counts for part in analysis.parts)
    for comparison in chain(of_parts, analysis.strays):
        yield from _rows_of_counts(comparison)


def _rows_of_counts(comparison: CountComparison) -> Rows:
    """A row a pose, and one of the parts in no stable pose."""
    counts = comparison.counts
    cells = [
        counts.part_id,
        counts.part_digest,
        *counts.numbering,
        counts.plate,
        counts.drop_height,
        _utc(counts.begin),
        _utc(counts.end),
    ]
    problem = comparison.problem
    if comparison.history is None:
        for pose, count in _rows(counts.index, counts.count):
            yield *cells, pose, count, "", "", "", problem
    else:
        for row in _rows(
            comparison.history.poses.index,
            comparison.count,
            comparison.share,
            *comparison.bounds,
        ):
            yield *cells, *row, problem
    share = counts.unclassified_share
    yield *cells, "unclassified", counts.unclassified, share, "", "", problem


def _comparison_rows(analysis: BagAnalysis) -> Rows:
    for part in analysis.parts:
        for history, simulations in zip(
            part.record.histories, part.simulations, strict=True
        ):
            for simulation in simulations:
                drops = int(simulation.simulation.count.sum())
                cells = [*_part_cells(part, history), "simulation", drops]
                yield from _rows_of_comparisons(simulation.estimates, cells)
        for counts in part.counts:
            if counts.history is not None:
                cells = [
                    *_part_cells(part, counts.history),
                    "camera",
                    counts.counts.classified,
                ]
                yield from _rows_of_comparisons(counts.predictions, cells)


def _rows_of_comparisons(comparisons: Sequence[Comparison], cells: list[Any]) -> Rows:
    """A row for the test by pose, and one for that by group, of each prediction."""
    for comparison in comparisons:
        for unit, test in (
            ("pose", comparison.by_pose),
            ("group", comparison.by_group),
        ):
            yield (
                *cells,
                *_values(comparison.prediction, SCENE),
                comparison.rms,
                comparison.largest,
                comparison.largest_pose,
                unit,
                *_values(test, TEST),
                comparison.unforeseen,
            )


ROWS = {
    "files": _file_rows,
    "poses": _pose_rows,
    "answers": _answer_rows,
    "jobs": _job_rows,
    "counts": _count_rows,
    "comparison": _comparison_rows,
}
