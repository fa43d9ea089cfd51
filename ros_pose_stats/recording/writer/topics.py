"""What a bag says about a topic beside its messages: type and offered quality of service."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from .message_types import MessageType

LATCHED: Final = frozenset(("/pose_stats/part_mesh", "/pose_stats/pose_statistics"))
"""Topics whose late subscribers get the last messages, in the cell and when a bag is played."""

DEPTH: Final = 100

_FOREVER = "\n    sec: 9223372036\n    nsec: 854775807"


@dataclass(frozen=True)
class Topic:
    """A recorded topic.

    Attributes
    ----------
    name : str
        Such as `/pose_stats/answers`.
    type_name, type_hash : str
        As in `MessageType`.
    qos : str
        YAML list with one profile, values as words, as rosbag2 writes it since metadata
        version 9.
    """

    name: str
    type_name: str
    type_hash: str
    qos: str


def described(types: Mapping[str, MessageType]) -> list[Topic]:
    """The topics of a run, in the order given."""
    return [Topic(name, kind.name, kind.type_hash, _qos(name in LATCHED))
            for name, kind in types.items()]


def _qos(latched: bool) -> str:
    return f"""\
- history: keep_last
  depth: {DEPTH}
  reliability: reliable
  durability: {"transient_local" if latched else "volatile"}
  deadline:{_FOREVER}
  lifespan:{_FOREVER}
  liveliness: automatic
  liveliness_lease_duration:{_FOREVER}
  avoid_ros_namespace_conventions: false"""
