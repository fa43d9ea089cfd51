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

"""What the commands `publish` and `show` ask of a running node."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import rclpy
from rclpy import exceptions, qos
from rclpy.node import Node
from rclpy.task import Future
from ros_pose_stats_msgs import msg
from ros_pose_stats_msgs.srv import GetStatistics

from ..base.errors import RequestError
from ..core.mesh import files, mass_properties, parts, units
from ..core.mesh.bodies import separation
from ..core.records import DropScene, Part, PoseStatistics
from ..core.records.scene import DEFAULT_RESTITUTION
from .messages import part_messages, part_requests, times
from .messages.statistics_messages import statistics_of_message
from .participant import create_client_node, join_ros
from .parts import part_builder
from .stop_signals import StopSignals

PATIENCE = 5.0  # seconds that a node is given to answer
UNCHECKED = 1.5  # seconds after which no more comes than an estimate without drops
GLANCE = 0.1  # seconds between looks at whether the end is asked for
LATCHED = qos.QoSProfile(depth=1024, durability=qos.DurabilityPolicy.TRANSIENT_LOCAL)
START = "start one: ros_pose_stats node"
OF_NODE = -1.0  # restitution or drop height of a part that has none of its own

Tell = Callable[[str], object]


@contextmanager
def ros_node(name: str, arguments: Sequence[str]) -> Iterator[tuple[Node, StopSignals]]:
    """A node of one's own, and whether SIGINT or SIGTERM has asked for the end."""
    stop = StopSignals()
    join_ros(arguments, "for instance --ros-args -r __ns:=/cell")
    node = None
    try:
        node = create_client_node(name)
        yield node, stop
    except RequestError:
        raise
    except (exceptions.NameValidationException, ValueError) as error:
        raise RequestError(
            "the name of a ROS topic or node", str(error), "for instance /pose_stats"
        ) from error
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()


def spin_until(
    node: Node,
    stop: StopSignals,
    ready: Callable[[], bool],
    seconds: float = math.inf,
) -> bool:
    """Whether something is so before the seconds are over or the end is asked for."""
    end = time.monotonic() + seconds
    while not (stop.is_requested or ready()) and time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=GLANCE)
    return ready()


def read_part(
    file: str,
    unit: str | None,
    center_of_mass: Sequence[float] | None,
    part_id: str,
    mass: float | None,
    density: float | None,
    body: separation.Choice,
) -> tuple[Part, msg.PartMesh]:
    """The part of a file, with all checks of the node, and its message.

    A file whose unit nobody names is refused: a cell acts on what is sent.
    """
    part_requests.check_name(part_id)
    mesh = files.read_mesh(file, unit)
    if mesh.unit_guessed:
        raise units.missing_unit(
            file,
            mesh.vertices,
            mesh.triangles,
            "give --unit mm, --unit inch or --unit m",
        )
    properties = mass_properties.check_properties(center_of_mass, mass, None, density)
    part = parts.part_of_file(mesh, properties, part_id, body)
    request = part_requests.PartRequest(
        part_id,
        np.asarray(mesh.vertices, dtype=np.float64),
        np.asarray(mesh.triangles, dtype=np.uint32),
        mesh.unit,
        body=separation.number_of_choice(body),
    )
    if any(value is not None for value in properties):
        request = replace(request, mass=part.mass, center_of_mass=part.center_of_mass)
    return part, part_messages.part_message(request, part_id, times.current_stamp())


class _PartResults:
    """Results of a part that has been published, in its scene, with their arrivals."""

    def __init__(self, part: Part, sent: msg.PartMesh) -> None:
        self._part = part
        self._sent = sent
        self.newest: msg.PoseStatistics | None = None
        self._arrival = 0.0  # of the newest one, on the monotonic clock

    def take(self, result: msg.PoseStatistics) -> None:
        """Keep a result of this part in this scene."""
        if (
            result.part_id == self._part.part_id
            and result.part_digest == self._part.digest
            and self._sent.restitution in (OF_NODE, result.restitution)
            and (
                self._sent.drop_height in (OF_NODE, result.drop_height)
                or math.isnan(result.drop_height)
            )
        ):
            self.newest = result
            self._arrival = time.monotonic()

    def are_complete(self) -> bool:
        """Whether there is a result, and no better one soon to come."""
        if self.newest is None:
            return False
        stamp = self.newest.header.stamp
        sent_stamp = self._sent.header.stamp
        is_new = (stamp.sec, stamp.nanosec) >= (sent_stamp.sec, sent_stamp.nanosec)
        if is_new and self.newest.drops > 0:
            return True
        is_slow = part_builder.is_large(self._part) and not is_new
        return time.monotonic() - self._arrival > (PATIENCE if is_slow else UNCHECKED)


def publish_part(
    part: Part,
    message: msg.PartMesh,
    restitution: float | None,
    drop_height: float | None,
    name: str,
    seconds: float | None,
    arguments: Sequence[str],
    tell: Tell,
    warn: Tell,
) -> Iterator[PoseStatistics]:
    """Publish a part, latched, until a node has answered; nothing after Ctrl-C.

    `restitution, drop_height`: default: the node's; `seconds`: default: without end.
    Yields what the node has latched.
    """
    # The node would refuse a scene that is out of range only once the part is there.
    DropScene(DEFAULT_RESTITUTION if restitution is None else restitution, drop_height)
    if seconds is not None and not seconds >= 0.0:
        raise RequestError("seconds from 0 on", f"{seconds}", "leave them out to go on")
    message.restitution = OF_NODE if restitution is None else restitution
    message.drop_height = OF_NODE if drop_height is None else drop_height
    results = _PartResults(part, message)
    patience = math.inf if seconds is None else seconds
    with ros_node("part_publisher", arguments) as (node, stop):
        publisher = node.create_publisher(msg.PartMesh, f"{name}/part_mesh", LATCHED)
        answers = node.create_subscription(
            msg.PoseStatistics, f"{name}/pose_statistics", results.take, LATCHED
        ).topic_name
        publisher.publish(message)
        tell(f"{part_requests.part_line(part)} published on {publisher.topic_name}")
        spin_until(node, stop, results.are_complete, min(patience, PATIENCE))
        if results.newest is None and not stop.is_requested:
            problem = f"no node answers on {answers}; {START}"
            if publisher.get_subscription_count():
                problem = "a node has the part but no result yet; its log says why"
            if patience > PATIENCE:
                warn(f"{problem}. Publishing on until one answers, or Ctrl-C")
                spin_until(node, stop, results.are_complete, patience - PATIENCE)
            if results.newest is None and not stop.is_requested:
                raise RequestError(f"a result within {seconds:g} s", "none", problem)
        if results.newest is not None:
            yield statistics_of_message(results.newest)


def latched_results(
    name: str, part_id: str, watch: bool, arguments: Sequence[str]
) -> Iterator[tuple[PoseStatistics, ...]]:
    """What a node has latched, of one part or all; then, watched, each new result."""
    messages: list[msg.PoseStatistics] = []
    with ros_node("pose_stats_show", arguments) as (node, stop):
        if watch:
            node.create_subscription(
                msg.PoseStatistics, f"{name}/pose_statistics", messages.append, LATCHED
            )
        service = node.create_client(GetStatistics, f"{name}/get_statistics")
        end = time.monotonic() + PATIENCE
        answer = None
        futures: list[Future[GetStatistics.Response]] = []

        def is_answered() -> bool:
            return any(future.done() for future in futures)

        while answer is None and time.monotonic() < end and not stop.is_requested:
            if spin_until(node, stop, service.service_is_ready, end - time.monotonic()):
                # Asked again: an answer to a client that has just been discovered may
                # be lost.
                futures.append(service.call_async(GetStatistics.Request()))
                if spin_until(node, stop, is_answered, 1.0):
                    answer = next(
                        future.result() for future in futures if future.done()
                    )
        if stop.is_requested:
            return
        if answer is None:
            raise RequestError(
                f"a node that answers on {service.service_name}",
                f"none within {PATIENCE:g} s",
                f"{START}, or give its --node",
            )
        revisions = {
            statistics.part_id: statistics.revision for statistics in answer.statistics
        }
        if part_id and part_id not in revisions:
            raise RequestError(
                f"a part that the node has a result of ({', '.join(revisions)})",
                f"'{part_id}'",
                "publish it first",
            )
        yield tuple(
            statistics_of_message(statistics)
            for statistics in answer.statistics
            if part_id in ("", statistics.part_id)
        )
        while watch and spin_until(node, stop, lambda: bool(messages)):
            result = messages.pop(0)
            if part_id in ("", result.part_id) and result.revision != revisions.get(
                result.part_id
            ):
                revisions[result.part_id] = result.revision
                yield (statistics_of_message(result),)
