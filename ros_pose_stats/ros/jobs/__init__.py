"""Simulations in the background, without a word of ROS."""

from .job import FlipRequest, Job, JobListener, JobRequest, State
from .queue import KEPT, Jobs

__all__ = ["KEPT", "FlipRequest", "Job", "JobListener", "JobRequest", "Jobs", "State"]
