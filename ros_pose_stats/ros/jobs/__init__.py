"""Drop simulations in the background, without a word of ROS."""

from .job import Job, JobListener, JobRequest, State
from .queue import KEPT, Jobs

__all__ = ["KEPT", "Job", "JobListener", "JobRequest", "Jobs", "State"]
