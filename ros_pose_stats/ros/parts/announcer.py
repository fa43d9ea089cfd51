"""What the node says of parts to others: latched results, markers, answers."""

import math
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rclpy import duration, event_handler, publisher as publishers, qos, serialization
from ros_pose_stats_msgs.msg import PoseStatistics
from visualization_msgs.msg import MarkerArray

from ...mesh.decimation import visible_triangles
from ...recording.writer import cdr as drawing
from ...text import most_probable
from ..base import Base
from ..messages import part_requests, statistics_messages, times
from ..recorder import PART_MESH, POSE_STATISTICS
from ..refusals import MOST_SWAPS
from .known_part import KnownPart, Memory

Array = NDArray[np.float64]

MOST_POSES = 16  # poses drawn of a part, the most probable ones
MOST_DRAWN = 400  # poses drawn in all; with many parts fewer of each

MOST_TRIANGLES = 32_000  # of the whole array: 2.3 MB, at most once a second
FINENESS = (4000, 2000, 1000, 500, 250, 100)  # triangles of a part, which is seldom made anew
GAP = 0.6  # between the parts, in radii
LETTER = 0.35  # height of the labels, in radii


def poses_each(parts: int) -> int:
    """How many poses of each of so many parts are drawn."""
    return max(1, min(MOST_POSES, MOST_DRAWN // max(parts, 1)))


def marker_array(rows: Sequence[tuple[PoseStatistics, Array]]) -> bytes:
    """Serialised markers, one row a part with its triangles, its poses side by side."""
    markers = [drawing.Marker(action=drawing.DELETE_ALL)]
    y = 0.0
    for result, triangles in rows:
        y -= result.radius * (1.0 + 0.5 * GAP) if markers[1:] else 0.0
        markers += _row(result, triangles, y, poses_each(len(rows)))
        y -= result.radius * (1.0 + 0.5 * GAP)
    return drawing.marker_array_message(markers)


def _row(result: PoseStatistics, triangles: Array, y: float, most: int) -> list[drawing.Marker]:
    corner = (-2.0 * result.radius, y, LETTER * result.radius)
    markers = [_label(result, 0, result.part_id, corner)]
    step = (2.0 + GAP) * result.radius
    for place, pose in enumerate(result.poses[:most]):
        x, where, turn = place * step, pose.pose.position, pose.pose.orientation
        unknown = math.isnan(pose.probability)
        depth = 0.0 if unknown else float(min(max(pose.probability, 0.0), 1.0)) ** 0.5  # of blue
        markers.append(drawing.Marker(
            result.header.frame_id, f"{result.part_id}/poses", drawing.TRIANGLE_LIST,
            (where.x + x, where.y + y, where.z, turn.x, turn.y, turn.z, turn.w),
            color=(0.85 - 0.75 * depth, 0.88 - 0.5 * depth, 0.92 - 0.2 * depth, 1.0),
            corners=triangles, number=pose.index))
        share = "-" if unknown else f"{100.0 * pose.probability:.1f} %"
        markers.append(_label(result, pose.index + 1, f"{pose.index}: {share}",
                              (x, y, pose.top + 0.5 * LETTER * result.radius)))
    return markers


def _label(result: PoseStatistics, number: int, text: str,
           where: tuple[float, float, float]) -> drawing.Marker:
    return drawing.Marker(
        result.header.frame_id, f"{result.part_id}/labels", drawing.TEXT_VIEW_FACING,
        (*where, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, LETTER * result.radius), (0.1, 0.1, 0.1, 1.0),
        text=text, number=number)


LATCHED = qos.QoSProfile(depth=1, reliability=qos.ReliabilityPolicy.RELIABLE,
                     durability=qos.DurabilityPolicy.TRANSIENT_LOCAL)
NO_EVENTS = event_handler.PublisherEventCallbacks(use_default_callbacks=False)
"""The executor fails on handlers of events that are destroyed while it waits for them."""

SECONDS_BETWEEN = 1.0  # markers
INTRODUCED = 4096  # meshes that are known to be in the bag
PARTING_SECONDS = 1.0  # for a subscriber to take a part's last message
NOT_RECORDED = "NOT_RECORDED: this could not be written down: {}."


@dataclass(eq=False)
class _Shown:
    """A part's own publisher, and what it latches."""

    publisher: publishers.Publisher
    known: KnownPart
    message: PoseStatistics
    recorded: bool  # whether that is in the bag; not so where a start shows it


class Announcer:
    """Publishes results, each part's by its own publisher, and records them after its mesh."""

    def __init__(self, base: Base) -> None:
        self._node, self._recorder, self._state = base.node, base.recorder, base.state
        self._floods = base.refusals.floods
        self._introduced: Memory[tuple[Path, str, str], bool] = Memory(INTRODUCED)  # by bag
        self._introducing = threading.RLock()
        self._shown: dict[str, _Shown] = {}
        self._leaving: dict[str, tuple[publishers.Publisher, float]] = {}
        self._lock = threading.Lock()
        self._changed = threading.Event()
        self._markers = base.node.create_publisher(MarkerArray, "~/markers", LATCHED)
        times.steady_timer(base.node, SECONDS_BETWEEN, self._look)

    def introduce(self, known: KnownPart) -> None:
        """Put a part's mesh on record, and the result that a start has latched, once a bag."""
        with self._introducing:
            name = known.part_id, known.digest
            if self._introduced.get((self._recorder.bag, *name)):
                return
            message = self._state.mesh(known.part_id)
            if message is None or not self._recorder.record(PART_MESH, message):
                return
            self._introduced.put((self._recorder.bag, *name), True)  # maybe a new bag's first
            shown = self._shown.get(known.part_id)
            if shown is not None and not shown.recorded:
                shown.recorded = self._recorder.record(POSE_STATISTICS,
                                                       serialization.serialize_message(shown.message))

    def log_part(self, known: KnownPart) -> None:
        """Say what has come, so that a wrong unit is seen at once; of a flood not each."""
        name = part_requests.shown(known.part_id)
        of_part = self._floods.count(f"meshes of part {name}", MOST_SWAPS)
        shown = known.shown
        if not (self._floods.count("new parts") and of_part) or shown is None:
            return
        log, poses = self._node.get_logger(), shown.latched.poses
        log.info(f"{part_requests.part_line(known.part)}, {len(poses)} stable poses "
                 f"({most_probable(poses)} % by {shown.latched.method}); "
                 f"bag {self._recorder.log.directory}")
        suspect = [line for line in shown.latched.warnings if line.startswith("HEIGHT_SUSPECT")]
        for warning in (*known.part.warnings, *suspect):
            log.warning(f"{known.part_id}: {warning}")

    def publish_result(self, known: KnownPart, message: PoseStatistics, data: bytes,
                       recorded: bool = True) -> None:
        """Latch a message, serialised too, as the part's current one."""
        with self._lock:
            publisher = self._publisher(known.part_id)
            self._shown[known.part_id] = _Shown(publisher, known, message, recorded)
            publisher.publish(data)
        self.draw()

    def draw(self) -> None:
        """Have markers drawn anew: something has changed in what they show."""
        self._changed.set()

    def _publisher(self, part_id: str) -> publishers.Publisher:
        """The part's own publisher, also one that was about to go."""
        if part_id in self._shown:
            return self._shown[part_id].publisher
        if part_id in self._leaving:
            return self._leaving.pop(part_id)[0]
        return self._node.create_publisher(PoseStatistics, "~/pose_statistics", LATCHED,
                                           event_callbacks=NO_EVENTS)

    def withdraw_result(self, known: KnownPart, stamp: int, reason: str) -> None:
        """Latch nothing for a part any more, and tell present subscribers that it is forgotten."""
        part_id = known.part_id
        with self._lock:
            shown = self._shown.pop(part_id, None)
        if shown is None:
            return
        data = serialization.serialize_message(statistics_messages.farewell_message(
            shown.message, stamp, known.revisions.next(), reason))
        self._recorder.record(POSE_STATISTICS, data)
        with self._lock:
            shown.publisher.publish(data)
            self._leaving[part_id] = shown.publisher, time.monotonic()
        self._changed.set()

    def _look(self) -> None:
        """See publishers off once their last message is there, and draw what has changed."""
        with self._lock:
            for part_id, (publisher, since) in list(self._leaving.items()):
                if (time.monotonic() - since > PARTING_SECONDS  # to wait would lock Python
                        or publisher.wait_for_all_acked(duration.Duration(seconds=0))):
                    del self._leaving[part_id]
                    self._node.destroy_publisher(publisher)
        if not self._changed.is_set():
            return
        self._changed.clear()
        with self._lock:
            shown = [self._shown[part_id] for part_id in sorted(self._shown)
                     if self._shown[part_id].known.source.is_built]
        each = poses_each(len(shown))
        drawn = sum(min(len(row.message.poses), each) for row in shown)
        most = next((fine for fine in FINENESS if fine * drawn <= MOST_TRIANGLES), FINENESS[-1])
        self._markers.publish(marker_array(
            [(row.message, visible_triangles(row.known.part, most)) for row in shown]))

    def close(self) -> None:
        """Wait for nobody any more."""
        with self._lock:
            while self._leaving:
                self._node.destroy_publisher(self._leaving.popitem()[1][0])

    def record(self, topic: str, known: KnownPart, message: PoseStatistics) -> PoseStatistics:
        """Put a result on record before anybody has it; the same, with a warning if that fails."""
        self.introduce(known)
        if self._recorder.record(topic, serialization.serialize_message(message)):
            return message
        return self.warn_unrecorded(message)

    def warn_unrecorded(self, message: PoseStatistics) -> PoseStatistics:
        """The same with the warning that it is not on record, which it has once."""
        if any(warning.startswith("NOT_RECORDED:") for warning in message.warnings):
            return message
        return statistics_messages.with_warning(message, self.not_recorded())

    def not_recorded(self) -> str:
        """The warning of an answer that is not in the bag, or not in the state."""
        return NOT_RECORDED.format(self._state.problem or self._recorder.last_problem)
