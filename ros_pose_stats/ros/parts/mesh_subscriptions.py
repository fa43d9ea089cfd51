"""Meshes from their topics: received, queued, and taken by the store or refused."""

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh

from ..messages.part_messages import request_of_mesh_bytes, request_of_part_bytes
from ..messages.part_requests import PartRequest, named
from ..refusals import Refusals
from ..settings import Settings, mesh_topics
from ..transport.batches import SequenceGaps
from . import known_part, part_builder
from .mesh_queue import MeshQueue

DEPTH = 100
"""Messages that wait in the middleware."""


def failed(error: Exception) -> Future[Any]:
    """A future that has failed."""
    future: Future[Any] = Future()
    future.set_exception(error)
    return future


class MeshSubscriptions:
    """Subscribes to `~/part_mesh` and to each of `mesh_topics`, and queues what comes."""

    def __init__(self, node: Node, settings: Callable[[], Settings],
                 take_part: Callable[[PartRequest], known_part.KnownPart], mesh_queue: MeshQueue,
                 refusals: Refusals) -> None:
        self._node = node
        self._settings = settings
        self._take_part = take_part
        self._mesh_queue = mesh_queue
        self._refusals = refusals
        self._group = MutuallyExclusiveCallbackGroup()
        self._subscribe(PartMesh, "~/part_mesh", request_of_part_bytes)
        for part_id, topic in mesh_topics(settings().mesh_topics).items():
            self._subscribe(Mesh, topic, self._reader(part_id))

    def _reader(self, part_id: str) -> Callable[[bytes], PartRequest]:
        return lambda data: request_of_mesh_bytes(data, part_id, self._settings().mesh_unit)

    def _subscribe(self, kind: type, topic: str, read: Callable[[bytes], PartRequest]) -> None:
        """Plain and latched publishers both arrive; a copy is ignored later."""
        def on_mesh(data: bytes) -> None:
            try:
                request = read(data)
            except Exception as error:  # a refusal, or a failure that is told like one
                self._refusals.watch_mesh(lambda: topic, failed(error))
                return
            coming = self._mesh_queue.put(partial(self._take_part, request), len(data),
                                          request.part_id, part_builder.is_large(request))
            self._refusals.watch_mesh(lambda: topic + named(request.part_id), coming)

        gaps = SequenceGaps()

        def on_counted_mesh(data: bytes, info: Mapping[str, int]) -> None:
            self._refusals.floods.count(f"meshes on {topic}")
            self._refusals.count_lost(
                gaps.missing_before(info["publication_sequence_number"] or 0))
            on_mesh(data)

        plain, latched = (
            QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE, durability=durability)
            for durability in (DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL))
        self._node.create_subscription(kind, topic, on_counted_mesh, plain, raw=True,
                                       callback_group=self._group)
        # Plain publishers do not match this one; what else is wrong with a publisher, the
        # plain subscription warns of.
        self._node.create_subscription(
            kind, topic, on_mesh, latched, raw=True, callback_group=self._group,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=lambda info: None))
