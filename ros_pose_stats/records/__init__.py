"""Frozen records that travel between the rooms."""

from .part import Part
from .progress import DropProgress
from .scene import DropScene
from .statistics import PoseStatistics, RestingShape, StablePose
from .trajectory import DropEvent, Trajectory

__all__ = ["DropEvent", "DropProgress", "DropScene", "Part", "PoseStatistics", "RestingShape",
           "StablePose", "Trajectory"]
