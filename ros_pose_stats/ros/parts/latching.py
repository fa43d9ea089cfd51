"""Which result a part shows to late joiners, and one latched publisher a part for it."""

from __future__ import annotations

import math
import threading
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_pose_stats_msgs.msg import PoseStatistics

LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE,
                     durability=DurabilityPolicy.TRANSIENT_LOCAL)
NO_EVENTS = PublisherEventCallbacks(use_default_callbacks=False)
"""The executor fails on handlers of events that are destroyed while it waits for them."""


def known_error(message: PoseStatistics) -> float:
    """Expected error of a result; where none has been measured, what a real plate leaves.

    An estimate whose error nobody knows is taken to be as good as that, so that a handful of
    drops does not push it aside.
    """
    error: float = message.expected_error
    return float(message.plate_error) if math.isnan(error) else error


def replaces(new: PoseStatistics, old: PoseStatistics) -> bool:
    """Whether a result takes the place of the latched one for the same scene.

    A larger expected error never replaces a smaller one for the same digest, but that a
    simulation ends what it has shown of itself: its last drops may raise the error a little.
    Of two estimates the newer one counts, which is by the method that is wanted now.
    """
    if not new.drops and not old.drops and new.method != old.method:
        return True
    if new.final and new.job_id and new.job_id == old.job_id:
        return True
    return new.part_digest != old.part_digest or known_error(new) <= known_error(old)


class LatchedPublishers:
    """One publisher a part on the same topic: reliable, transient local, depth 1.

    A late joiner gets the current result of every part, whatever the others do.

    Parameters
    ----------
    node : Node
    topic : str
    """

    def __init__(self, node: Node, topic: str) -> None:
        self._node = node
        self._topic = topic
        self._publishers: dict[str, Publisher] = {}
        self._lock = threading.Lock()

    def publish(self, part_id: str, data: bytes) -> None:
        """Publish a serialised message as the part's current one."""
        with self._lock:
            publisher = self._publishers.get(part_id)
            if publisher is None:
                publisher = self._node.create_publisher(
                    PoseStatistics, self._topic, LATCHED, event_callbacks=NO_EVENTS)
                self._publishers[part_id] = publisher
            publisher.publish(data)

    def withdraw(self, part_id: str) -> None:
        """Latch nothing for a part any more."""
        with self._lock:
            publisher: Any = self._publishers.pop(part_id, None)
            if publisher is not None:
                self._node.destroy_publisher(publisher)
