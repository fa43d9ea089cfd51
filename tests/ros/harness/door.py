"""What stands behind the node's topics and services, without a node and without a disk."""

from __future__ import annotations

from collections import Counter
from concurrent.futures import Future

from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.action import SimulateDrops

from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.ros.diagnostics import Refusals
from ros_pose_stats.ros.jobs import Jobs
from ros_pose_stats.ros.jobs.job_reports import JobReports
from ros_pose_stats.ros.messages.camera_messages import counts_of_bytes, observed_of_bytes
from ros_pose_stats.ros.messages.part_messages import request_of_mesh_bytes, request_of_part_bytes
from ros_pose_stats.ros.observed_parts import count_observed
from ros_pose_stats.ros.parts.mesh_queue import MeshQueue
from ros_pose_stats.ros.parts.part_requests import named
from ros_pose_stats.ros.parts.refinement import Refinement
from ros_pose_stats.ros.pose_counts import count_problem
from ros_pose_stats.ros.requests import Requests
from ros_pose_stats.ros.services import Services
from ros_pose_stats.ros.settings import settings_of

from .client import until
from .node import PATIENCE
from .quiet import FakeRecorder, fake_node, quiet_results

SERVICES = {
    srv.EstimatePoses.Request: (srv.EstimatePoses.Response, "estimate"),
    srv.StartDropSimulation.Request: (srv.StartDropSimulation.Response, "start"),
    srv.GetStatistics.Request: (srv.GetStatistics.Response, "get_statistics"),
    srv.ForgetPart.Request: (srv.ForgetPart.Response, "forget"),
    srv.GetDropSimulation.Request: (srv.GetDropSimulation.Response, "get"),
    srv.CancelDropSimulation.Request: (srv.CancelDropSimulation.Response, "cancel"),
}
REQUESTS = (*SERVICES, SimulateDrops.Goal)

SMALL = {"max_drops": 60, "drops": 20, "max_parts": 12, "workers": 1, "max_mesh_bytes": 20_000,
         "max_queued_jobs": 4}
LONGEST_LINE = 2500
"""Characters of a refusal; it may name eight known parts."""

TAKEN, REFUSED, DROPPED = "taken", "refused", "dropped"


class Door:
    """The functions that the node's callbacks call.

    Attributes
    ----------
    outcomes : Counter
        How many messages were taken, refused, and dropped by the middleware.
    failures : list of str
        What the node would have logged as failures of its own.
    """

    def __init__(self):
        self.settings = settings_of(SMALL)
        self.outcomes, self.failures, self.refusals = Counter(), [], []
        recorder, here = FakeRecorder(), self.settings
        node = fake_node(self.failures)
        self.results = quiet_results(here, recorder, node)
        self.mesh_queue = MeshQueue(lambda: here.max_mesh_bytes)
        reports = JobReports(self.results, recorder, lambda line: None)
        self.jobs = Jobs("run", reports, self.failures.append)
        self.requests = Requests(lambda: here, self.results, self.mesh_queue, self.jobs,
                                 Refusals(self.refusals.append))
        self._services = Services(node, lambda: here, self.results, self.requests,
                                  Refinement(lambda: here, self.results, self.jobs), self.jobs,
                                  reports)
        self.mesh_queue.start()
        self.jobs.start()

    def part(self, data):
        """A message on ~/part_mesh."""
        self._judge(lambda: self._take(request_of_part_bytes(data)))

    def mesh(self, data):
        """One on a topic of mesh_topics."""
        self._judge(lambda: self._take(request_of_mesh_bytes(data, "part", 1.0)))

    def counts(self, data):
        """One on ~/pose_counts."""
        self._judge(lambda: assert_line(count_problem(counts_of_bytes(data),
                                                      self.results.parts.current)))

    def observed(self, data):
        """One on ~/observed_parts."""
        def look():
            counts = count_observed(observed_of_bytes(data), self.results.parts.current,
                                    self.settings)
            assert counts is None or not count_problem(counts, self.results.parts.current)

        self._judge(look)

    def ask(self, kind, data):
        """A request as the middleware gives it to a service or the action."""
        try:
            request = deserialize_message(data, kind)
        except Exception:  # the bindings raise what they like; no callback is called
            self.outcomes[DROPPED] += 1
            return
        if kind is SimulateDrops.Goal:
            self._judge(lambda: self.requests.start_job(request))
        else:
            self._answer(kind, request)

    def _answer(self, kind, request):
        answer_type, name = SERVICES[kind]
        response = getattr(self._services, name)(request, answer_type())
        if isinstance(response, Future):
            response = response.result(PATIENCE)
        assert serialize_message(response)
        assert response.success or response.message
        assert_line(response.message)
        self.outcomes[TAKEN if response.success else REFUSED] += 1

    def _take(self, request):
        assert_line(named(request.part_id))
        self.results.take_part(request)

    def _judge(self, work):
        """Nothing but a refusal may come out."""
        try:
            work()
        except PoseStatsError as refusal:
            assert_line(str(refusal))
            self.outcomes[REFUSED] += 1
        else:
            self.outcomes[TAKEN] += 1

    def assert_sound(self):
        """Everything happened, and no fault of the program."""
        assert not self.failures, self.failures
        for line in self.refusals:
            assert_line(line)
        assert self.outcomes[TAKEN] and self.outcomes[REFUSED]

    def close(self):
        self.mesh_queue.close()
        until(lambda: self.jobs.close("the test ended"), "the end of the drop in hand")


def assert_line(text):
    """A line that a terminal can show, and none of an internal failure."""
    assert text.isprintable() and len(text) <= LONGEST_LINE, ascii(text)
    assert "internal failure" not in text, text
