"""Simulations in the background, without a word of ROS."""

from .queue import Jobs
from .run import FlipRequest, Job, JobListener, JobRequest, State

__all__ = ["FlipRequest", "Job", "JobListener", "JobRequest", "Jobs", "State"]
