"""Keeps the markers up to date with what is latched."""

from __future__ import annotations

import threading

from geometry_msgs.msg import Point
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from visualization_msgs.msg import MarkerArray

from ..messages.markers import corners, marker_array, poses_each, triangles_each
from .catalogue import KnownPart
from .latching import LATCHED
from .results import Results

SECONDS_BETWEEN = 1.0


class MarkerPublisher:
    """Publishes the markers of all parts, at most once a second.

    Parameters
    ----------
    node : Node
    results : Results
    """

    def __init__(self, node: Node, results: Results) -> None:
        self._results = results
        self._publisher = node.create_publisher(MarkerArray, "~/markers", LATCHED)
        self._changed = threading.Event()
        self._corners: dict[tuple[str, int], list[Point]] = {}
        node.create_timer(SECONDS_BETWEEN, self._tick,
                          callback_group=MutuallyExclusiveCallbackGroup())

    def touch(self) -> None:
        """Something has changed."""
        self._changed.set()

    def _tick(self) -> None:
        if not self._changed.is_set():
            return
        self._changed.clear()
        shown = [known for known in self._results.parts.all() if known.latched is not None]
        shown.sort(key=lambda known: known.part.part_id)
        each = poses_each(len(shown))
        drawn = sum(min(len(known.latched.poses), each) for known in shown)
        most = triangles_each(drawn)
        kept = {(known.part.digest, most): self._soup(known, most) for known in shown}
        self._corners = kept
        self._publisher.publish(marker_array(
            [(known.latched, kept[known.part.digest, most]) for known in shown]))

    def _soup(self, known: KnownPart, most: int) -> list[Point]:
        found = self._corners.get((known.part.digest, most))
        return corners(known.part, most) if found is None else found
