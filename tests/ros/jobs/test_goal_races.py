"""Goals and jobs that meet at bad moments, with goals that the test controls."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from action_msgs.msg import GoalStatus
from ros_pose_stats_msgs.msg import PartMesh, PoseStatistics

from ros_pose_stats.ros.jobs import State, goals
from ros_pose_stats.ros.jobs.simulate_drops import SimulateDropsServer

from ..harness.client import until
from .fake_jobs import Listener, queue_of, submit


class FakeGoal:
    """A goal as rclpy's, whose end is told at once.

    Attributes
    ----------
    before_executing : callable
        Called between the look at the goal's state and its transition.
    """

    def __init__(self, number):
        self.request = SimpleNamespace(part=PartMesh())
        self.goal_id = SimpleNamespace(uuid=bytes([number] * 16))
        self.status = GoalStatus.STATUS_ACCEPTED
        self.before_executing = lambda: None
        self.results = []

    @property
    def is_cancel_requested(self):
        return self.status == GoalStatus.STATUS_CANCELING

    @property
    def is_active(self):
        return self.status <= GoalStatus.STATUS_CANCELING

    def execute(self, callback):
        if not self.is_cancel_requested:
            self.before_executing()
            if self.status != GoalStatus.STATUS_ACCEPTED:
                raise RuntimeError("invalid transition")
            self.status = GoalStatus.STATUS_EXECUTING
        self.end = lambda: self.results.append(callback(self))

    def cancel(self):
        self.status = GoalStatus.STATUS_CANCELING

    def canceled(self):
        self.status = GoalStatus.STATUS_CANCELED

    def succeed(self):
        self.status = GoalStatus.STATUS_SUCCEEDED

    def abort(self):
        self.status = GoalStatus.STATUS_ABORTED

    def publish_feedback(self, feedback):
        pass


class Reports(Listener):
    """A listener that passes on to the action."""

    def hook(self, event, job):
        {"started": self.on_started, "progressed": self.on_progress,
         "told": self.on_end}.get(event, lambda job: None)(job)

    def current_answer(self, job):
        return PoseStatistics()


@pytest.fixture
def meeting(monkeypatch):
    """The action around a queue, without ROS."""
    monkeypatch.setattr(goals, "PatientActionServer", lambda *args, **kwargs: None)
    reports = Reports()
    reports.hook = lambda event, job: Reports.hook(reports, event, job)
    with queue_of(monkeypatch, reports, started=False) as (jobs, simulation):
        requests = SimpleNamespace(start_job=lambda request: submit(jobs))
        node = SimpleNamespace(get_logger=lambda: SimpleNamespace(error=print))
        yield SimpleNamespace(
            server=SimulateDropsServer(node, requests, jobs, reports), jobs=jobs,
            simulation=simulation, requests=requests)


def test_a_cancel_between_look_and_transition(meeting):
    goal = FakeGoal(1)
    meeting.server._ask(goal.request)
    meeting.server._accepted(goal)
    job = meeting.jobs.all()[0]
    goal.before_executing = goal.cancel
    meeting.jobs.start()
    until(lambda: job.state == State.RUNNING)
    meeting.jobs.cancel(job.job_id, "cancelled by a client")
    until(job.finished.is_set)
    assert (job.state, meeting.jobs.failures) == (State.CANCELLED, [])
    goal.end()
    assert goal.status == GoalStatus.STATUS_CANCELED


def test_a_cancel_between_the_answer_and_the_callback_that_follows_it(meeting):
    goal = FakeGoal(1)
    meeting.server._ask(goal.request)
    assert meeting.server._cancel(goal) == goals.CancelResponse.ACCEPT
    goal.cancel()
    job = meeting.jobs.all()[0]
    until(job.finished.is_set)
    meeting.server._accepted(goal)
    goal.end()
    assert goal.status == GoalStatus.STATUS_CANCELED


def test_the_job_ends_before_the_goal_is_tied_to_it(meeting):
    goal = FakeGoal(1)
    meeting.server._ask(goal.request)
    meeting.simulation.let(1000)
    meeting.jobs.start()
    until(meeting.jobs.all()[0].finished.is_set)
    meeting.server._accepted(goal)
    goal.end()
    assert goal.status == GoalStatus.STATUS_SUCCEEDED


def test_a_slow_transition_to_cancelling(meeting):
    goal = FakeGoal(1)
    meeting.server._ask(goal.request)
    meeting.server._accepted(goal)
    assert meeting.server._cancel(goal) == goals.CancelResponse.ACCEPT
    job = meeting.jobs.all()[0]
    assert not job.finished.wait(0.2)
    goal.cancel()
    until(job.finished.is_set)
    goal.end()
    assert goal.status == GoalStatus.STATUS_CANCELED


def test_an_internal_failure_refuses_the_goal(meeting):
    goal = FakeGoal(1)
    meeting.requests.start_job = lambda request: 1 / 0
    meeting.server._ask(goal.request)
    goal.execute = lambda: None
    meeting.server._accepted(goal)
    result = meeting.server._refuse(goal)
    assert goal.status == GoalStatus.STATUS_ABORTED
    assert not result.success and "ZeroDivisionError" in result.message
