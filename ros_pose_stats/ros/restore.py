"""A node that starts goes on with what its state has, and takes in the end of its last bag."""

import json
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs import msg

from ..errors import RequestError
from ..recording.analysis.decoding import Decoders
from ..recording.reader import RawMessage, files_of_bag, raw_messages
from ..recording.writer.message_types import message_type
from ..records import DropScene
from .jobs import Job, JobRequest, State as JobState
from .jobs.job_reports import job_change
from .recorder import ANSWERS, JOB_EVENTS, PACKAGE, PLACE, POSE_COUNTS, Recorder, share_directory
from .settings import Settings
from .state import MESSAGES, Change, State

INTERRUPTED = "the node ended before the simulation did"

TAKEN = {POSE_COUNTS: "PoseCounts", JOB_EVENTS: "JobEvent", ANSWERS: "PoseStatistics"}

_decoders = Decoders()


@cache
def _definition(kind: str) -> str:
    return message_type(f"{PACKAGE}/msg/{kind}", share_directory).definition


def definitions() -> dict[str, str]:
    """Definitions of the messages in the state, by type, as they are installed."""
    return {kind: _definition(kind) for kinds in MESSAGES.values() for kind in kinds.values()}


def as_of_today(kind: str, definition: str, data: bytes) -> bytes | None:
    """A message of another definition, by the names of its fields; None where it is unreadable."""
    if definition == _definition(kind):
        return data
    decoded = _decoders.decode(RawMessage("", f"{PACKAGE}/msg/{kind}", data, 0, definition))
    if decoded is None:
        return None
    return bytes(serialize_message(_filled(getattr(msg, kind)(), decoded)))


def _filled(message: Any, decoded: Any) -> Any:
    for name, kind in message.get_fields_and_field_types().items():
        value, default = getattr(decoded, name, None), getattr(message, name)
        if value is None:
            continue
        if hasattr(default, "get_fields_and_field_types"):
            _filled(default, value)
        elif "/" in kind:
            package, _, type_name = kind.removeprefix("sequence<").rstrip(">").partition("/")
            make = getattr(import_module(f"{package}.msg"), type_name)
            setattr(message, name, [_filled(make(), item) for item in value])
        else:
            setattr(message, name, value)
    return message


@dataclass
class Tail:
    """What the last bag has beyond the state: at most what came within the last second or two."""

    counts: list[msg.PoseCounts] = field(default_factory=list)
    events: list[msg.JobEvent] = field(default_factory=list)
    answers: dict[str, bytes] = field(default_factory=dict)  # of jobs that had ended, by job


def tail_of(state: State, warn: Callable[[str], object]) -> Tail:
    """Read it; a bag that is not there any more has none."""
    tail, fact = Tail(), state.get("facts", PLACE)
    if fact is None:
        return tail
    place, offset, time, inode = [*json.loads(fact[1]), 0, 0][:4]  # older ones have only two
    path = Path(place)
    try:
        if path.is_file():
            files = files_of_bag(path.parent)
            files = files[files.index(path):]
        else:  # a whole bag, which had no file then
            files = files_of_bag(path) if path.is_dir() else []
        for file in files:
            # Whoever mended the file wrote it anew, and what was damaged before the place is gone.
            same = file == path and inode in (0, file.stat().st_ino)
            for message in raw_messages(file, begin=offset if same else 0):
                kind = TAKEN.get(message.topic, "") if message.log_time > time else ""
                data = as_of_today(kind, message.definition, message.data) if kind else None
                if data is None:
                    continue
                read = deserialize_message(data, getattr(msg, kind))
                if message.topic == POSE_COUNTS:
                    tail.counts.append(read)
                elif message.topic == JOB_EVENTS and read.job_id:
                    tail.events.append(read)
                elif read.job_id:
                    tail.answers[read.job_id] = data
    except Exception as error:  # of the disk, or of bindings about what was cut
        warn(f"not all of the end of the last bag could be read: {type(error).__name__}: {error}")
    return tail


def restore_jobs(state: State, tail: Tail, settings: Settings) -> tuple[list[Job], list[Change]]:
    """Jobs of earlier runs, oldest first, and what is to be recorded of those cancelled now."""
    rows: dict[str, tuple[msg.JobEvent, bytes]] = {}
    for job_id, _, event, answer in state.rows("jobs"):
        with suppress(Exception):  # of the bindings; the checksums were right, so it is an old one
            rows[job_id] = deserialize_message(event, msg.JobEvent), answer
    for event in tail.events:
        before, kept = rows.get(event.job_id, (None, b""))
        if before is None or before.event < msg.JobEvent.DONE:
            answer = tail.answers.get(event.job_id, kept)
            rows[event.job_id] = event, answer
            state.put(job_change(event, answer))
    jobs: list[Job] = []
    cancelled: list[Change] = []
    for job_id in sorted(rows, key=lambda name: (name.rpartition("_")[0], len(name), name)):
        event, answer = rows[job_id]
        if event.event < msg.JobEvent.DONE:
            event.event, event.message = msg.JobEvent.CANCELLED, INTERRUPTED
            cancelled.append(job_change(event, answer))
        with suppress(RequestError):  # a scene that today's bounds do not allow
            scene = DropScene(event.restitution,
                              event.drop_height if event.drop_height > 0.0 else None,
                              event.cluster_tolerance, event.round_sides)
            request = JobRequest(event.part_id, b"", scene, event.drops, event.seed,
                                 event.target_error, event.max_seconds, event.refinement)
            jobs.append(Job(job_id, request, Future(), event.seed, settings,
                            JobState(event.event), event.drops_done, message=event.message))
            jobs[-1].finished.set_result(None)
    return jobs, cancelled


def record_cancelled(cancelled: list[Change], recorder: Recorder, state: State,
                     warn: Callable[[str], object]) -> None:
    """Put on record that jobs were cancelled, once: the next start reads of those it did."""
    for change in cancelled:
        row = change.row or ()
        with recorder.step:
            recorder.record(JOB_EVENTS, row[2])
            state.put(change)
        warn(f"{row[0]}: CANCELLED: {INTERRUPTED}")
