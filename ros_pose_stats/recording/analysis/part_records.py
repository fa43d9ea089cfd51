"""What collectors gathered, sorted by part."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from .bag_contents import PartRecord
from .drop_log import DropCollector, DropLog
from .jobs import Job, JobCollector
from .result_collector import ResultCollector

PartKey = tuple[str, str]
"""Name and digest."""


def part_records(results: Mapping[PartKey, Mapping[float, ResultCollector]], jobs: JobCollector,
                 drops: DropCollector) -> tuple[PartRecord, ...]:
    """A record a part, in the order of first appearance: in results, then in jobs."""
    jobs_of: dict[PartKey, list[Job]] = {}
    for job in jobs.jobs.values():
        jobs_of.setdefault((job.part_id, job.part_digest), []).append(job)
    keys = dict.fromkeys((*results, *jobs_of, *jobs.forgotten))
    return tuple(
        _record(key, list(results.get(key, {}).values()), jobs_of.get(key, ()),
                tuple(sorted(jobs.forgotten.get(key, ()))), drops.logs.get(key[1], DropLog()))
        for key in keys)


def _record(key: PartKey, found: Sequence[ResultCollector], jobs: Sequence[Job],
            forgotten: tuple[int, ...], drop_log: DropLog) -> PartRecord:
    histories = sorted((one.history() for one in found), key=lambda one: -len(one.time))
    plates = (each.plate for one in histories for each in one.predictions)
    return PartRecord(
        *key,
        radius=found[0].radius if found else math.nan,
        histories=tuple(histories),
        jobs=tuple(sorted(jobs, key=lambda job: (job.queued or job.started or job.ended,
                                                 job.job_id))),
        forgotten=forgotten,
        warnings=tuple(dict.fromkeys(line for one in found for line in one.warnings)),
        plates=tuple(dict.fromkeys(name for name in plates if name)),
        drop_log=drop_log)
