"""Drop simulations in the background, without a word of ROS."""

from .job import Job, JobRequest, State
from .queue import JobListener, Jobs

__all__ = ["Job", "JobListener", "JobRequest", "Jobs", "State"]
