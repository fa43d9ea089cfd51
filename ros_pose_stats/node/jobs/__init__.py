"""Simulations in the background: their queue, their runs, and what reports them."""

from .queue import Jobs
from .run import FlipRequest, Job, JobListener, JobRequest, State

__all__ = ["FlipRequest", "Job", "JobListener", "JobRequest", "Jobs", "State"]
