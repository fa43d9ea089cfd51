"""The action `~/simulate_drops`: the same jobs with feedback and cancel."""

from typing import Any

from ros_pose_stats_msgs.action import SimulateDrops
from ros_pose_stats_msgs.msg import PartMesh

from ..jobs import Job, Jobs
from ..jobs.job_reports import JobReports
from ..transport.answering_node import AnsweringNode
from .goals import GoalServer
from .requests import Requests


class SimulateDropsServer(GoalServer):
    """Goals that are drop simulations."""

    def __init__(self, node: AnsweringNode, requests: Requests, jobs: Jobs,
                 reports: JobReports) -> None:
        self._requests = requests
        self._reports = reports
        super().__init__(node, SimulateDrops, "simulate_drops", jobs, reports)

    def start_job(self, request: Any) -> Job:
        """Accept a drop simulation."""
        try:
            return self._requests.start_job(request)
        finally:  # the goal is kept for a while
            request.part = PartMesh(part_id=request.part.part_id)

    def feedback(self, job: Job) -> Any:
        """How far a simulation is."""
        return SimulateDrops.Feedback(
            job_id=job.job_id, drops_done=job.drops_done, drops_total=job.request.drops,
            expected_error=job.expected_error, drops_per_second=job.drops_per_second)

    def result(self, job: Job | None, success: bool, message: str) -> Any:
        """The statistics of what was done."""
        found = SimulateDrops.Result(success=success, message=message)
        if job is not None:
            found.job_id, found.statistics = job.job_id, self._reports.current_answer(job)
        return found
