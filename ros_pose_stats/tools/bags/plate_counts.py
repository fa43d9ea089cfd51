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

"""Counts of cameras on a plate, with the parts that they are of, out of bags."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from ...base.errors import PoseStatsError, RequestError
from ...base.text import listed, several
from ...core.plates import CountedPart, count_part, read_counted_parts
from ...core.plates.counts import shared_out
from ...core.records import Part
from .bag_reader import OnProgress, read_bags, read_parts
from .camera_counts import CameraCounts


def counts_on_plate(
    paths: Sequence[Path], plate: str, on_progress: OnProgress | None
) -> tuple[list[CountedPart], list[str]]:
    """Counts of a plate with their parts out of the same bags; notes on unused counts.

    Counts that name no plate are taken too, as those of the only plate there was.
    """
    recorded_counts = read_bags(paths, on_progress).counts
    plate_counts = [
        counts
        for counts in recorded_counts
        if counts.plate in ("", plate) and counts.classified
    ]
    if not plate_counts:
        plates = sorted({counts.plate for counts in recorded_counts if counts.plate})
        raise RequestError(
            f"counts of cameras on plate {plate}",
            f"those of {listed(plates)}" if plates else "none",
            "name its plate, or record ~/pose_counts",
        )
    parts = _read_parts_of(plate_counts, paths)
    counted_parts = []
    notes = []
    for counts in plate_counts:
        candidates = [
            part for part in parts if counts.are_of(part.part_id, part.digest)
        ]
        problem = _problem(counts, candidates)
        if not problem:
            try:
                counted_parts.append(
                    count_part(
                        candidates[0], counts.of_pose, **counts.numbering._asdict()
                    )
                )
            except PoseStatsError as refusal:
                problem = str(refusal)
        if problem:
            notes.append(
                f"{several(counts.classified, 'count')} of {counts.part_id} left out: "
                f"{problem}"
            )
    return counted_parts, notes


def read_table_counts(table: Path, unit: str) -> list[CameraCounts]:
    """Counts of a table by hand, a part each, as cameras' are; at the table's time.

    `unit`: of files of parts that name none. Poses that look alike share theirs evenly.
    """
    counted_parts = read_counted_parts(table, unit)
    time = table.stat().st_mtime_ns
    return [
        CameraCounts(
            counted_part.part.part_id,
            counted_part.part.digest,
            counted_part.numbering,
            plate="",
            drop_height=math.nan,
            begin=time,
            end=time,
            messages=1,
            of_pose=Counter(dict(enumerate(shared_out(counted_part).tolist()))),
        )
        for counted_part in counted_parts
    ]


def _read_parts_of(
    plate_counts: Sequence[CameraCounts], paths: Sequence[Path]
) -> Iterable[Part]:
    """Parts in bags, each once, until all are there that were counted."""
    missing_digests = {counts.part_digest for counts in plate_counts}
    parts: dict[str, Part] = {}
    for part in read_parts(paths):
        parts.setdefault(part.digest, part)
        missing_digests.discard(part.digest)
        if not missing_digests:
            break
    return parts.values()


def _problem(counts: CameraCounts, candidates: Sequence[Part]) -> str:
    """Why counts cannot be used with the parts that fit them; empty if they can."""
    if len(candidates) > 1:
        return "several parts have this name, and the counts carry no digest"
    if not candidates:
        return "its mesh is not in the bags"
    if counts.unknown_code:
        return f"no result in the bags has their numbering {counts.unknown_code}"
    if math.isnan(counts.numbering.cluster_tolerance):
        return "they do not say by which cluster_tolerance the poses are numbered"
    return ""
