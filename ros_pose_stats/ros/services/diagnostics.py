"""What the node says of its own health, once a second on /diagnostics."""

from collections.abc import Callable, Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node

from ..jobs import Jobs
from ..messages.times import now, steady_timer, time_message
from ..refusals import Health
from ..settings import Settings


def job_health(jobs: Jobs, settings: Settings) -> Health:
    """The line about drop simulations."""
    asked, refinements = jobs.counts()
    job = jobs.running
    text = "idle" if job is None else (
        f"{job.job_id}: {job.drops_done} of {job.request.drops} drops of '{job.part_id}'")
    return Health(False, text, {
        "queued": asked, "refinements queued": refinements,
        "queue bound": settings.max_queued_jobs, "running": "" if job is None else job.job_id,
        "threads": settings.threads()})


def flip_health(goals: Jobs, answers: Jobs) -> Health:
    """The line about flips, those of goals and of answers of ~/feeding."""
    running = [job for job in (goals.running, answers.running) if job is not None]
    text = "; ".join(f"{job.job_id}: {job.drops_done} flips of '{job.part_id}'"
                     for job in running)
    return Health(False, text or "idle", {
        "goals queued": goals.counts()[0], "answers queued": answers.counts()[0],
        "running": ", ".join(job.job_id for job in running)})


class Diagnostics:
    """Publishes all lines, each with what it is about, once a second."""

    def __init__(self, node: Node, lines: Mapping[str, Callable[[], Health]]) -> None:
        self._name = node.get_fully_qualified_name()[1:]
        self._lines = lines
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        steady_timer(node, 1.0, self._publish, MutuallyExclusiveCallbackGroup())

    def _publish(self) -> None:
        message = DiagnosticArray(status=[
            self._status(about, health()) for about, health in self._lines.items()])
        message.header.stamp = time_message(now())
        self._publisher.publish(message)

    def _status(self, about: str, health: Health) -> DiagnosticStatus:
        level = DiagnosticStatus.WARN if health.warn else DiagnosticStatus.OK
        return DiagnosticStatus(
            level=level, name=f"{self._name}: {about}", message=health.text, hardware_id="",
            values=[KeyValue(key=key, value=str(value)) for key, value in health.values.items()])
