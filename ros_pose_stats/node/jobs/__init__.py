"""Simulations in the background: queue and runs know no ROS, what reports them does."""

from .queue import Jobs
from .run import FlipRequest, Job, JobListener, JobRequest, State

__all__ = ["FlipRequest", "Job", "JobListener", "JobRequest", "Jobs", "State"]
