"""A client that takes little time itself: raw subscriptions, spun in the calling
thread.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.task import Future
from ros_pose_stats_msgs.msg import PoseStatistics

PATIENCE = 60.0
OWN = "/pose_stats"


def quiet() -> PublisherEventCallbacks:
    """Callbacks without warnings about readers of latched meshes only; the node has
    both kinds.
    """
    return PublisherEventCallbacks(incompatible_qos=lambda _: None)


class Client:
    """Publishes meshes, sees what is latched, and calls services.

    Attributes
    ----------
    node : rclpy Node
    """

    def __init__(self) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node("benchmark", context=self.context)
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)
        self._services: dict[str, Any] = {}
        self._publishers: dict[str, Any] = {}
        self._seen: deque[bytes] = deque(maxlen=100)
        self.node.create_subscription(
            PoseStatistics,
            f"{OWN}/pose_statistics",
            lambda data: self._seen.append(data),
            QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL),
            raw=True,
        )

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: Any) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()

    def spin_until(self, condition: Callable[[], object], description: str) -> None:
        """Handle messages until `done()`.

        Raises
        ------
        TimeoutError
            If that takes too long; `what` is named in it.
        """
        deadline = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(f"no {description} within {PATIENCE:.0f} s")
            self._executor.spin_once(timeout_sec=0.02)

    def spin_for(self, seconds: float) -> None:
        """Handle messages for a time."""
        deadline = time.monotonic() + seconds
        while (remaining := deadline - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=remaining)

    def result(self, future: Future, description: str) -> Any:
        """Wait for an answer and return it."""
        future.add_done_callback(lambda _: self._executor.wake())
        self.spin_until(future.done, description)
        return future.result()

    def service(self, kind: type, name: str) -> Any:
        """A service's client, ready to be called."""
        if name not in self._services:
            client = self._services[name] = self.node.create_client(kind, name)
            self.spin_until(client.service_is_ready, f"service {name}")
        return self._services[name]

    def call(self, kind: type, name: str, request: Any) -> Any:
        """Call a service of the node, or with a leading slash any other one."""
        name = name if name.startswith("/") else f"{OWN}/{name}"
        return self.result(
            self.service(kind, name).call_async(request), f"answer from {name}"
        )

    def connect(self, kind: type, topic: str, readers: int = 1) -> None:
        """Make a publisher and wait for its readers."""
        publisher = self._publishers[topic] = self.node.create_publisher(
            kind, topic, 10, event_callbacks=quiet()
        )
        self.spin_until(
            lambda: publisher.get_subscription_count() >= readers, f"reader of {topic}"
        )
        self.spin_for(0.2)  # the other side's matching follows

    def publish(self, topic: str, data: bytes) -> None:
        """Publish a serialised message on a connected topic."""
        self._publishers[topic].publish(data)

    def forget_latched(self) -> None:
        """Forget the messages of the latched topic."""
        self._seen.clear()

    def has_latched(self, text: str) -> bool:
        """Whether a result with that name or digest in it has come since then."""
        needle = text.encode()
        return any(needle in message for message in self._seen)

    def publish_until_latched(self, topic: str, data: bytes, digest: str) -> None:
        """Publish a mesh and wait for the latched result of its digest."""
        self.forget_latched()
        self.publish(topic, data)
        self.spin_until(lambda: self.has_latched(digest), f"result of {digest}")
