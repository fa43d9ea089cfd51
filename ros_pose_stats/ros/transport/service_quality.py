"""How services take requests: none is lost where many come at once."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

WAITING = 1000
"""Requests, and answers, that wait; ROS's own default of ten loses the others silently."""

SERVICE_QUALITY = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=WAITING, reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE)
