"""Frozen records that travel between the rooms.

They are loaded when they are first used: the command line takes defaults from `scene`, and must
not load numpy for `--version` or `--help`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .flips import FlipStatistics
    from .part import Part
    from .scene import DropScene
    from .statistics import PoseStatistics, RestingShape, StablePose
    from .trajectory import DropEvent, DropProgress, Trajectory

_HOMES = {"DropEvent": "trajectory", "DropProgress": "trajectory", "DropScene": "scene",
          "FlipStatistics": "flips", "Part": "part", "PoseStatistics": "statistics",
          "RestingShape": "statistics", "StablePose": "statistics", "Trajectory": "trajectory"}

__all__ = ["DropEvent", "DropProgress", "DropScene", "FlipStatistics", "Part",
           "PoseStatistics", "RestingShape", "StablePose", "Trajectory"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value
