"""What the bags of earlier runs leave to a node that starts: parts, results, unfinished jobs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics

from ...errors import RequestError
from ...recording.finished import is_finished
from ...recording.reader.raw_reader import RawMessage, finished_runs, raw_messages
from ...records import DropScene
from ..messages.mesh_views import NotPlainCdrError, part_and_digest_of
from ..messages.part_messages import request_of_part_bytes
from ..parts.part_requests import PartRequest

PART_MESH = "ros_pose_stats_msgs/msg/PartMesh"
POSE_STATISTICS = "ros_pose_stats_msgs/msg/PoseStatistics"
JOB_EVENT = "ros_pose_stats_msgs/msg/JobEvent"

MOST_REVISION = 2**63
"""Results are numbered from 1; the next ones must fit into the message too."""

MOST_INDEX = 2**31 - 1
"""Of a pose, as markers can carry it."""


def bags_to_restore(log_directory: Path, node: str) -> list[Path]:
    """Bags of a node that nobody has mended yet and the newest of its others, oldest first.

    Several nodes may share a log directory; each goes on with what it recorded itself.

    A node mends bags only after it has put on record what they leave to it. So where nodes
    were killed while they started, their bags are here together with those before them.
    """
    try:
        dead = finished_runs(log_directory)
    except OSError:  # the repair that follows says so
        return []
    found: list[Path] = []
    newest = False
    for bag in reversed(dead):
        with suppress(OSError):
            finished = is_finished(bag)
            first = next(raw_messages(bag), None)
            if first is not None and first.node != node:
                continue
            if finished and (newest or first is None):
                continue
            newest = newest or finished
            found.insert(0, bag)
    return found


class Place(NamedTuple):
    """Where a mesh is: number of the bag, and of the message in it."""

    bag: int
    message: int


class CurrentMeshes:
    """Tells which of the meshes recorded under a part's name is the present one.

    It follows meshes and results in the order in which they were recorded, and keeps only the
    newest mesh of each part. Each mesh is recorded once, so where an earlier one came back under
    its name, only the results that follow tell, by their digest.
    """

    def __init__(self) -> None:
        self._newest: dict[str, tuple[Place, PartRequest]] = {}
        self._places: dict[tuple[str, str], Place] = {}
        self._present: dict[str, Place] = {}
        self._unseen: set[str] = set()

    def note_mesh(self, request: PartRequest, place: Place) -> None:
        """The next mesh."""
        self._newest[request.part_id] = place, request
        self._unseen.add(request.part_id)
        self._make_present(request.part_id, place)

    def note_result(self, part_id: str, digest: str) -> None:
        """The next result; the first one after a new mesh tells that mesh's digest."""
        if part_id in self._unseen:
            self._unseen.remove(part_id)
            self._places[part_id, digest] = self._newest[part_id][0]
        place = self._places.get((part_id, digest))
        if place is not None and place != self._present.get(part_id):
            self._make_present(part_id, place)

    def forget(self, part_id: str) -> None:
        """The part was forgotten; its meshes stay on record, if it comes again."""
        self._present.pop(part_id, None)

    def present(self, read_again: Callable[[], Iterable[tuple[Place, Path, RawMessage]]],
                ) -> dict[str, PartRequest]:
        """The present mesh of each part, in the order in which they became that.

        Everything is read again only if an earlier mesh came back.
        """
        found = {part_id: self._newest[part_id][1] for part_id in self._present}
        wanted = {place: part_id for part_id, place in self._present.items()
                  if place != self._newest[part_id][0]}
        for place, _, message in read_again() if wanted else ():
            if place in wanted:
                found[wanted[place]] = request_of_part_bytes(message.data)
        return found

    def _make_present(self, part_id: str, place: Place) -> None:
        self._present.pop(part_id, None)
        self._present[part_id] = place


def scene_of(event: JobEvent) -> DropScene:
    """The scene of a job.

    Raises
    ------
    RequestError
        If there is no such scene.
    """
    height = event.drop_height if event.drop_height > 0.0 else None
    return DropScene(event.restitution, height, event.cluster_tolerance)


@dataclass
class LastRun:
    """What bags leave to the next run.

    Attributes
    ----------
    parts : dict of str to PartRequest
        The present mesh of each part, in the order in which they became that.
    unfinished : dict of str to JobEvent
        Jobs that were accepted and not heard of again.
    results : dict of str to PoseStatistics
        The last result of each of the parts; nothing is going to refine it any more.
    problems : dict of Path to str
        Bags not all of which could be read, and the first reason.
    """

    parts: dict[str, PartRequest] = field(default_factory=dict)
    unfinished: dict[str, JobEvent] = field(default_factory=dict)
    results: dict[str, PoseStatistics] = field(default_factory=dict)
    problems: dict[Path, str] = field(default_factory=dict)
    _meshes: CurrentMeshes = field(default_factory=CurrentMeshes)
    _latched: dict[str, tuple[Path, bytes]] = field(default_factory=dict)

    def take(self, bag: Path, place: Place, message: RawMessage) -> None:
        """Take in the next message."""
        kind, data = message.type_name, message.data
        if kind == PART_MESH:
            self._meshes.note_mesh(request_of_part_bytes(data), place)
        elif kind == POSE_STATISTICS and message.topic.endswith("/pose_statistics"):
            part_id, digest = _part_and_digest(data)
            self._meshes.note_result(part_id, digest)
            self._latched[part_id] = bag, data
        elif kind == JOB_EVENT:
            self._take_event(deserialize_message(data, JobEvent))

    def conclude(self, bags: Sequence[Path]) -> None:
        """Find the parts and their results, once everything was taken in."""
        self.parts = self._meshes.present(lambda: _messages(bags, self.note))
        for part_id in self.parts.keys() & self._latched.keys():
            bag, data = self._latched[part_id]
            try:
                self.results[part_id] = _result(data)
            except Exception as error:  # the bindings raise what they like
                self.note(bag, error)

    def note(self, bag: Path, error: Exception) -> None:
        """Something in a bag cannot be read."""
        reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
        self.problems.setdefault(bag, reason)

    def _take_event(self, event: JobEvent) -> None:
        if event.event == JobEvent.PART_FORGOTTEN:
            self._meshes.forget(event.part_id)
            self._latched.pop(event.part_id, None)
        elif event.event in (JobEvent.QUEUED, JobEvent.RUNNING):
            scene_of(event)
            self.unfinished[event.job_id] = event
        else:
            self.unfinished.pop(event.job_id, None)


def _part_and_digest(data: bytes) -> tuple[str, str]:
    try:
        return part_and_digest_of(data)
    except NotPlainCdrError:  # another encapsulation
        message = deserialize_message(data, PoseStatistics)
        return message.part_id, message.part_digest


def _result(data: bytes) -> PoseStatistics:
    """A recorded result that can be gone on with."""
    message = deserialize_message(data, PoseStatistics)
    if not message.revision < MOST_REVISION:
        raise RequestError("a revision below 2^63", f"{message.revision}", "estimate it again")
    if not all(pose.index < MOST_INDEX for pose in message.poses):
        raise RequestError(f"pose indices below {MOST_INDEX}", "a larger one",
                           "estimate it again")
    message.final = True
    return message


def last_run(bags: Sequence[Path]) -> LastRun:
    """Read bags in order; what cannot be read is left out and named."""
    found = LastRun()
    for place, bag, message in _messages(bags, found.note):
        try:
            found.take(bag, place, message)
        except Exception as error:  # of the bindings, about other versions and damage
            found.note(bag, error)
    found.conclude(bags)
    return found


def _messages(bags: Sequence[Path], on_problem: Callable[[Path, Exception], object],
              ) -> Iterator[tuple[Place, Path, RawMessage]]:
    """All messages of bags, as far as the disk gives them."""
    for number, bag in enumerate(bags):
        try:
            for k, message in enumerate(raw_messages(bag)):
                yield Place(number, k), bag, message
        except Exception as error:
            on_problem(bag, error)
