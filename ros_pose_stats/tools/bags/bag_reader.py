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

"""What bags hold of this package, read in one go."""

import math
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path
from typing import Any, TypeAlias

from ...base.errors import BagError
from ...base.text import several
from ...core.records import Part
from ...core.records.notes import Note, has_note
from ...core.records.scene import Numbering, numbering_of
from ...node.recording import decoding
from ...node.recording.reader import RawMessage
from . import camera_counts
from .bag_files import FileMessages, OnRead, find_bags
from .jobs import DropCollector, DropLog, Job, JobCollector
from .results import ResultCollector, ResultHistory

ANSWERS = "answers"
PartKey = tuple[str, str]  # name and digest
OnProgress = Callable[[int, int], None]  # takes the bytes read, and of how many
Paths: TypeAlias = "str | os.PathLike[str] | Iterable[str | os.PathLike[str]]"


@dataclass(frozen=True)
class BagFile:
    """One file of a bag, and how whole it was."""

    bag: Path
    path: Path
    state: str  # `whole`, `open`, `cut`, `damaged` or `unreadable`
    note: str  # the same for people; empty where it is whole
    messages: int  # of this package's types that were read


@dataclass(frozen=True, eq=False)
class PartRecord:
    """What the bags hold about one part, which a name and a digest stand for."""

    part_id: str
    part_digest: str
    radius: float  # metres; NaN where no result tells it
    # one a numbering, the one with most results first
    histories: tuple[ResultHistory, ...]
    jobs: tuple[Job, ...]  # by time
    forgotten: tuple[int, ...]  # when the node forgot the part, nanoseconds since 1970
    warnings: tuple[Note, ...]  # of all results, the last of a code in each scene
    plates: tuple[str, ...]  # named by results
    drop_log: DropLog  # drops recorded one by one


@dataclass(frozen=True, eq=False)
class BagContents:
    """All of it."""

    files: tuple[BagFile, ...]
    messages: dict[str, int]  # how many of each type were read, copies included
    begin: int  # when the first of them was recorded, nanoseconds since 1970
    end: int  # when the last was
    parts: tuple[PartRecord, ...]  # in the order of first appearance
    counts: tuple[camera_counts.CameraCounts, ...]
    notes: tuple[str, ...]  # what could not be read or used, one sentence each

    @property
    def bags(self) -> tuple[Path, ...]:
        """The bags that were read."""
        return tuple(dict.fromkeys(file.bag for file in self.files))

    @property
    def whole_bags(self) -> set[Path]:
        """Those of them of which nothing was lost."""
        return set(self.bags) - {
            file.bag for file in self.files if file.state != "whole"
        }


def read_bags(paths: Paths, on_progress: OnProgress | None) -> BagContents:
    """Read directories of bags, bags or files; `on_progress`: bytes, of how many."""
    if isinstance(paths, (str, os.PathLike)):
        paths = [paths]
    bags = find_bags(map(Path, paths))
    return _BagReader().read(bags, on_progress or (lambda count, total: None))


class _BagReader:
    """Reads once; see `read_bags`."""

    def __init__(self) -> None:
        self._decoders = decoding.Decoders()
        self._files: list[BagFile] = []
        self._messages: Counter[str] = Counter()
        self._begin = 0
        self._end = 0
        self._sources: dict[tuple[Path, str], int] = {}
        self._results: dict[PartKey, dict[Numbering, ResultCollector]] = {}
        self._jobs = JobCollector()
        self._counts = camera_counts.CountCollector()
        self._drops = DropCollector()
        self._notes: Counter[str] = Counter()

    def read(
        self, bags: Mapping[Path, Sequence[Path]], on_progress: OnProgress
    ) -> BagContents:
        """Read all of it."""
        sizes: Counter[Path] = Counter()
        for file in chain(*bags.values()):
            with suppress(OSError):  # that comes again as it is read
                sizes[file] = file.stat().st_size
        bytes_read = 0
        total = sum(sizes.values())

        def show(share: float) -> None:
            on_progress(bytes_read + round(share * sizes[file]), total)

        for bag, files in bags.items():
            for file in files:
                self._read_file(bag, file, show)
                bytes_read += sizes[file]
        if not self._messages:
            raise self._no_messages(bags)
        return BagContents(
            tuple(self._files),
            dict(sorted(self._messages.items())),
            self._begin,
            self._end,
            tuple(_part_records(self._results, self._jobs, self._drops)),
            tuple(self._counts.all()),
            tuple(self._remarks()),
        )

    def _no_messages(self, bags: Iterable[Path]) -> BagError:
        damage = ""
        for file in self._files:
            if file.state != "whole":
                damage = f" ({file.path.name} {file.note})"
                break
        names = ", ".join(map(str, islice(bags, 3)))
        return BagError(
            f"messages of {decoding.PACKAGE} in {names}",
            f"none in {several(len(self._files), 'file')}{damage}",
            "name a bag of the node, or one recorded with its topics",
        )

    def _read_file(self, bag: Path, file: Path, on_read: OnRead) -> None:
        messages = FileMessages(file, on_read)
        count = 0
        for message in messages:
            if decoding.kind_of(message.type_name):
                count += 1
                self._add(message, bag)
        if bag == file and messages.state == "unreadable":
            raise BagError(
                "a bag's file or a bag directory",
                f"{file}, which {messages.note}",
                "check the path",
            )
        self._files.append(BagFile(bag, file, messages.state, messages.note, count))

    def _add(self, raw: RawMessage, bag: Path) -> None:
        kind = decoding.kind_of(raw.type_name)
        if not self._messages:
            self._begin = raw.log_time
            self._end = raw.log_time
        self._messages[kind] += 1
        self._begin = min(self._begin, raw.log_time)
        self._end = max(self._end, raw.log_time)
        # A mesh may be large and slow to decode, and nothing of it is needed here.
        message = None if kind == decoding.PART_MESH else self._decoders.decode(raw)
        if message is None:
            return
        try:
            stamp = decoding.stamp_of(message)
            if kind == decoding.POSE_STATISTICS:
                self._add_result(message, stamp or raw.log_time, raw.topic)
            elif kind == decoding.JOB_EVENT:
                self._jobs.add(message, stamp or raw.log_time)
            elif kind == decoding.POSE_COUNTS:
                source = self._sources.setdefault((bag, raw.topic), len(self._sources))
                self._counts.add(message, source, stamp, raw.log_time)
            elif kind == decoding.DROP_RECORDS:
                self._drops.add(message)
        except (AttributeError, OverflowError, TypeError, ValueError):
            # A definition of another kind under our name, or numbers that cannot be.
            self._decoders.failures += 1

    def _add_result(self, message: Any, time: int, topic: str) -> None:
        if not getattr(message, "poses", ()):
            if has_note(message, "FORGOTTEN"):
                digest = str(getattr(message, "part_digest", ""))
                self._jobs.note_forgotten(str(message.part_id), digest, time)
            else:
                self._notes["{} left out, without poses: result"] += 1
            return
        key = (
            str(getattr(message, "part_id", "")),
            str(getattr(message, "part_digest", "")),
        )
        numbering = numbering_of(message)
        collector = self._results.get(key, {}).get(numbering) or ResultCollector(
            message, numbering
        )
        if not collector.fits(message):
            self._notes[
                "{} left out, numbering other poses than the first one of the same "
                "part, cluster_tolerance and round_sides: result"
            ] += 1
            return
        latched = topic.rpartition("/")[2] != ANSWERS
        collector.add(message, time, latched)
        self._counts.note_result(message, numbering, latched)
        self._results.setdefault(key, {})[numbering] = collector

    def _remarks(self) -> list[str]:
        counts = self._counts
        left_out = {
            **self._notes,
            "{} left out, broken or of another definition: message": (
                self._decoders.failures
            ),
            "{} left out, with more poses than numbers or fewer: camera count": (
                counts.refused
            ),
            "{} left out, of flips and not of landings: camera count": counts.flips,
            "{} in several bags, counted once: camera count": counts.copies.count,
            "{} without a time stamp; copies in other bags were recognized by the time "
            "of recording (within 1 s): camera count": counts.copies.unstamped,
        }
        remarks = []
        for template, count in left_out.items():
            sentence, _, noun = template.rpartition(": ")
            if count:
                remarks.append(sentence.format(several(count, noun)))
        return remarks


def _part_records(
    results: Mapping[PartKey, Mapping[Numbering, ResultCollector]],
    jobs: JobCollector,
    drops: DropCollector,
) -> Iterator[PartRecord]:
    """A record a part, in the order of first appearance: in results, then in jobs."""
    keys = dict.fromkeys(results)
    jobs_of_part: dict[PartKey, list[Job]] = {}
    for job in jobs.jobs.values():
        key = (job.part_id, job.part_digest)
        keys[key] = None
        jobs_of_part.setdefault(key, []).append(job)
    keys.update(dict.fromkeys(jobs.forgotten))
    for key in keys:
        collectors = list(results.get(key, {}).values())
        histories = sorted(
            (collector.history() for collector in collectors),
            key=lambda history: -len(history.time),
        )
        warnings = chain.from_iterable(collector.warnings for collector in collectors)
        plates = {
            prediction.plate: None
            for history in histories
            for prediction in history.predictions
            if prediction.plate
        }
        yield PartRecord(
            *key,
            collectors[0].radius if collectors else math.nan,
            tuple(histories),
            tuple(sorted(jobs_of_part.get(key, ()), key=_job_order)),
            tuple(sorted(jobs.forgotten.get(key, ()))),
            tuple(dict.fromkeys(warnings)),
            tuple(plates),
            drops.logs.get(key[1], DropLog()),
        )


def _job_order(job: Job) -> tuple[int, str]:
    return job.queued or job.started or job.ended, job.job_id


def read_parts(paths: Iterable[Path]) -> Iterator[Part]:
    """Every sound part in bags, in the order of recording; BagError without a bag."""
    decoders = decoding.Decoders()
    for files in find_bags(paths).values():
        for file in files:
            for message in FileMessages(file, lambda share: None):
                if decoding.kind_of(message.type_name) == decoding.PART_MESH:
                    mesh = decoders.decode(message)
                    part = None if mesh is None else decoding.part_of(mesh)
                    if part is not None:
                        yield part
