"""Frozen records that travel between the rooms."""

from .part import Part
from .scene import DropScene
from .statistics import PoseStatistics, StablePose

__all__ = ["DropScene", "Part", "PoseStatistics", "StablePose"]
