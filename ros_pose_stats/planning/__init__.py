"""Which method answers a request: an estimate, drops, or both combined."""

from .auto import auto
from .hybrid import hybrid, hybrid_statistics
from .prior import pose_prior

__all__ = ["auto", "hybrid", "hybrid_statistics", "pose_prior"]
