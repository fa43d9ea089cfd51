"""Simulations in the background, without a word of ROS."""

from .queue import KEPT, Jobs
from .run import FlipRequest, Job, JobListener, JobRequest, State

__all__ = ["KEPT", "FlipRequest", "Job", "JobListener", "JobRequest", "Jobs", "State"]
