"""A latched publisher for a CAD file."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rclpy
from rclpy.exceptions import InvalidTopicNameException
from rclpy.signals import SignalHandlerOptions
from ros_pose_stats_msgs.msg import PartMesh

from ..errors import RequestError
from ..mesh import files, mass_properties, parts
from ..records import DropScene, scene as scenes
from .messages.part_messages import part_message
from .messages.part_requests import PartRequest, check_name, part_line
from .messages.times import now
from .parts.announcer import LATCHED
from .stop_signals import StopSignals


def publish_part(file: str, unit: str | None, center_of_mass: Sequence[float] | None,
                 part_id: str, topic: str, seconds: float | None,
                 arguments: Sequence[str], *, mass: float | None = None,
                 density: float | None = None, restitution: float | None = None,
                 drop_height: float | None = None) -> int:
    """Publish until SIGINT, SIGTERM or the end of the time; raises PoseStatsError.

    `unit`: default: what the file declares, else metres; `part_id`: empty: the file's stem;
    `density`: kg/m³, in place of the mass; `restitution, drop_height`: default: the node's.
    """
    if seconds is not None and not seconds >= 0.0:
        raise RequestError("seconds from 0 on", f"{seconds}", "leave them out to go on")
    # The node would refuse a scene that is out of range only once the part has arrived there.
    DropScene(scenes.DEFAULT_RESTITUTION if restitution is None else restitution, drop_height)
    part_id = part_id or Path(file).stem
    check_name(part_id)
    mesh = files.read_mesh(file, unit)
    properties = mass_properties.check_given(center_of_mass, mass, None, density)
    part = parts.part_of_file(mesh, properties, part_id)  # what the node would refuse, too
    given = (part.mass, part.center_of_mass) if any(
        value is not None for value in properties) else ()
    message = part_message(PartRequest(
        part_id, np.asarray(mesh.vertices, dtype=np.float64),
        np.asarray(mesh.triangles, dtype=np.uint32), mesh.unit, *given), part_id, now())
    if restitution is not None:
        message.restitution = restitution
    if drop_height is not None:
        message.drop_height = drop_height
    stop = StopSignals()
    rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = rclpy.create_node("part_publisher")
        try:
            publisher = node.create_publisher(PartMesh, topic, LATCHED)
        except (InvalidTopicNameException, ValueError) as error:
            raise RequestError("the name of a ROS topic", f"'{topic}'",
                               "for instance /pose_stats/part_mesh") from error
        publisher.publish(message)
        print(f"{part_line(part, None)} published on {topic}", *part.warnings, sep="\n",
              flush=True)
        stop.wait(math.inf if seconds is None else seconds)
        node.destroy_node()
    finally:
        rclpy.try_shutdown()
    return 0
