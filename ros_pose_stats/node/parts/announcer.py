"""What the node says of parts to others: latched results, markers, answers."""

import math
import threading
import time
from collections.abc import Sequence
from pathlib import Path

from rclpy import duration, event_handler, publisher as publishers, qos, serialization
from ros_pose_stats_msgs.msg import PoseStatistics
from visualization_msgs.msg import MarkerArray

from ...base.text import most_probable
from ...core.mesh.decimation import visible_triangles
from ...core.records import Array
from ..equipment import Equipment
from ..messages import part_requests, statistics_messages, times
from ..recorder import PART_MESH, POSE_STATISTICS
from ..recording.writer import cdr as drawing
from ..refusals import MOST_SWAPS
from .known_part import KnownPart, Memory

MOST_POSES = 16  # poses drawn of a part, the most probable ones
MOST_DRAWN = 400  # poses drawn in all; with many parts fewer of each

MOST_TRIANGLES = 32_000  # of the whole array: 2.3 MB, at most once a second
FINENESS = (
    4000,
    2000,
    1000,
    500,
    250,
    100,
)  # triangles of a part, which is seldom made anew
GAP = 0.6  # between the parts, in radii
LETTER = 0.35  # height of the labels, in radii


def marker_array(rows: Sequence[tuple[PoseStatistics, Array]], most: int) -> bytes:
    """Serialised markers, a row a part with its triangles, at most so many poses side by side."""
    markers = [drawing.Marker(action=drawing.DELETE_ALL)]
    y = 0.0
    for result, triangles in rows:
        y -= result.radius * (1.0 + 0.5 * GAP) if markers[1:] else 0.0
        markers += _row(result, triangles, y, most)
        y -= result.radius * (1.0 + 0.5 * GAP)
    return drawing.marker_array_message(markers)


def _row(
    result: PoseStatistics, triangles: Array, y: float, most: int
) -> list[drawing.Marker]:
    corner = (-2.0 * result.radius, y, LETTER * result.radius)
    markers = [_label(result, 0, result.part_id, corner)]
    step = (2.0 + GAP) * result.radius
    for place, pose in enumerate(result.poses[:most]):
        x = place * step
        where = pose.pose.position
        turn = pose.pose.orientation
        unknown = math.isnan(pose.probability)
        depth = (
            0.0 if unknown else float(min(max(pose.probability, 0.0), 1.0)) ** 0.5
        )  # of blue
        markers.append(
            drawing.Marker(
                result.header.frame_id,
                f"{result.part_id}/poses",
                drawing.TRIANGLE_LIST,
                (where.x + x, where.y + y, where.z, turn.x, turn.y, turn.z, turn.w),
                color=(
                    0.85 - 0.75 * depth,
                    0.88 - 0.5 * depth,
                    0.92 - 0.2 * depth,
                    1.0,
                ),
                corners=triangles,
                number=pose.index,
            )
        )
        share = "-" if unknown else f"{100.0 * pose.probability:.1f} %"
        markers.append(
            _label(
                result,
                pose.index + 1,
                f"{pose.index}: {share}",
                (x, y, pose.top + 0.5 * LETTER * result.radius),
            )
        )
    return markers


def _label(
    result: PoseStatistics, number: int, text: str, where: tuple[float, float, float]
) -> drawing.Marker:
    return drawing.Marker(
        result.header.frame_id,
        f"{result.part_id}/labels",
        drawing.TEXT_VIEW_FACING,
        (*where, 0.0, 0.0, 0.0, 1.0),
        (0.0, 0.0, LETTER * result.radius),
        (0.1, 0.1, 0.1, 1.0),
        text=text,
        number=number,
    )


LATCHED = qos.QoSProfile(
    depth=1,
    reliability=qos.ReliabilityPolicy.RELIABLE,
    durability=qos.DurabilityPolicy.TRANSIENT_LOCAL,
)
NO_EVENTS = event_handler.PublisherEventCallbacks(use_default_callbacks=False)
"""The executor fails on handlers of events that are destroyed while it waits for them."""

SECONDS_BETWEEN = 1.0  # markers
INTRODUCED = 4096  # meshes that are known to be in the bag
PARTING_SECONDS = 1.0  # for a subscriber to take a part's last message
NOT_RECORDED = "NOT_RECORDED: this could not be written down: {}."


class Announcer:
    """Publishes results, each part's by its own publisher, and records them after its mesh."""

    def __init__(self, equipment: Equipment) -> None:
        self._node = equipment.node
        self._recorder = equipment.recorder
        self._state = equipment.state
        self._floods = equipment.refusals.floods
        self._introduced: Memory[tuple[Path, str, str], bool] = Memory(
            INTRODUCED
        )  # by bag
        self._introducing = threading.RLock()
        self._publishers: dict[str, publishers.Publisher] = {}  # by part
        self._shown: dict[str, KnownPart] = {}
        self._leaving: dict[str, float] = {}  # since when, of parts that are forgotten
        self._lock = threading.Lock()
        self._changed = threading.Event()
        self._markers = equipment.node.create_publisher(
            MarkerArray, "~/markers", LATCHED
        )
        times.steady_timer(equipment.node, SECONDS_BETWEEN, self._look)

    def introduce(self, known: KnownPart) -> None:
        """Put a part's mesh on record once a bag, and what it shows where that is not yet."""
        with self._introducing:
            name = known.part_id, known.digest
            if self._introduced.get((self._recorder.bag, *name)):
                return
            message = self._state.mesh(known.part_id)
            if message is None or not self._recorder.record(PART_MESH, message):
                return
            self._introduced.put(
                (self._recorder.bag, *name), True
            )  # maybe a new bag's first
            shown = known.shown
            if shown is not None and not shown.recorded:
                shown.recorded = self._recorder.record(
                    POSE_STATISTICS, serialization.serialize_message(shown.latched)
                )

    def log_part(self, known: KnownPart) -> None:
        """Say what has come, so that a wrong unit is seen at once; of a flood not each."""
        name = part_requests.shown(known.part_id)
        of_part = self._floods.count(f"meshes of part {name}", MOST_SWAPS)
        shown = known.shown
        if not (self._floods.count("new parts") and of_part) or shown is None:
            return
        log = self._node.get_logger()
        poses = shown.latched.poses
        log.info(
            f"{part_requests.part_line(known.part)}, {len(poses)} stable poses "
            f"({most_probable(poses)} % by {shown.latched.method}); "
            f"bag {self._recorder.log.directory}"
        )
        suspect = [
            line for line in shown.latched.warnings if line.startswith("HEIGHT_SUSPECT")
        ]
        for warning in (*known.part.warnings, *suspect):
            log.warning(f"{known.part_id}: {warning}")

    def publish_result(self, known: KnownPart, data: bytes) -> None:
        """Latch what a part shows, serialised, by its own publisher."""
        with self._lock:
            self._leaving.pop(known.part_id, None)
            if known.part_id not in self._publishers:
                self._publishers[known.part_id] = self._node.create_publisher(
                    PoseStatistics,
                    "~/pose_statistics",
                    LATCHED,
                    event_callbacks=NO_EVENTS,
                )
            self._shown[known.part_id] = known
            self._publishers[known.part_id].publish(data)
        self.draw()

    def draw(self) -> None:
        """Have markers drawn anew: something has changed in what they show."""
        self._changed.set()

    def withdraw_result(self, known: KnownPart, stamp: int, reason: str) -> None:
        """Latch nothing for a part any more, and tell present subscribers that it is forgotten."""
        with self._lock:
            last = self._shown.pop(known.part_id, None)
        if last is None or last.shown is None:
            return
        data = serialization.serialize_message(
            statistics_messages.farewell_message(
                last.shown.latched, stamp, known.revisions.next(), reason
            )
        )
        self._recorder.record(POSE_STATISTICS, data)
        with self._lock:
            self._publishers[known.part_id].publish(data)
            self._leaving[known.part_id] = time.monotonic()
        self.draw()

    def _look(self) -> None:
        """See publishers off once their last message is there, and draw what has changed."""
        with self._lock:
            for part_id, since in list(self._leaving.items()):
                publisher = self._publishers[part_id]
                if (
                    time.monotonic() - since
                    > PARTING_SECONDS  # to wait would lock Python
                    or publisher.wait_for_all_acked(duration.Duration(seconds=0))
                ):
                    del self._leaving[part_id], self._publishers[part_id]
                    self._node.destroy_publisher(publisher)
        if not self._changed.is_set():
            return
        self._changed.clear()
        with self._lock:
            rows = [
                (known, known.shown.latched)
                for _, known in sorted(self._shown.items())
                if known.source.part is not None and known.shown is not None
            ]
        each = max(1, min(MOST_POSES, MOST_DRAWN // max(len(rows), 1)))
        drawn = sum(min(len(result.poses), each) for _, result in rows)
        most = next(
            (fine for fine in FINENESS if fine * drawn <= MOST_TRIANGLES), FINENESS[-1]
        )
        self._markers.publish(
            marker_array(
                [
                    (result, visible_triangles(known.part, most))
                    for known, result in rows
                ],
                each,
            )
        )

    def record(
        self, topic: str, known: KnownPart, message: PoseStatistics
    ) -> PoseStatistics:
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
