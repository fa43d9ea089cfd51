"""The node `pose_stats`: wiring only."""

from __future__ import annotations

from concurrent.futures import Future, wait
from functools import partial
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

from .diagnostics import Diagnostics, Refusals, job_health
from .jobs import Jobs
from .jobs.job_reports import JobReports
from .jobs.simulate_drops import SimulateDropsServer
from .messages.times import follow_clock, steady_timer
from .parameters import Parameters
from .parts.announcer import Announcer
from .parts.mesh_queue import MeshQueue
from .parts.mesh_subscriptions import MeshSubscriptions
from .parts.part_store import KnownPart, PartStore
from .parts.refinement import Refinement
from .parts.result_store import SECONDS_BETWEEN, ResultStore
from .pose_counts import CountSubscription
from .recorder import Recorder
from .requests import Requests
from .restart.last_run import bags_to_restore, last_run
from .restart.restore import end_unfinished_jobs, restore_parts
from .services import Services
from .settings import Settings
from .transport.late_answers import PatientNode


class PoseStatsNode(PatientNode):
    """Takes meshes, answers with stable poses and their probabilities, drops parts.

    Raises
    ------
    PoseStatsError
        If a parameter is refused.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("pose_stats", **options)
        follow_clock(self.get_clock())
        self.table = Parameters(self, self._on_change)
        settings, log = self._settings(), self.get_logger()
        self.recorder = Recorder(settings, self.get_fully_qualified_name(), log.warning)
        self.refusals = Refusals(log.warning)
        self.announcer = Announcer(self, self.recorder, self.refusals.floods)
        self.parts = PartStore(self.recorder, self.announcer.withdraw_result)
        self.results = ResultStore(self._settings, self.parts, self.announcer)
        self.mesh_queue = MeshQueue(lambda: 2 * self._settings().max_mesh_bytes)
        self.reports = JobReports(self.results, self.recorder, log.info)
        self.recorder.on_gap = self._record_again
        self.jobs = Jobs(self.recorder.log.directory.name.removeprefix("pose_stats_"),
                         self.reports, log.error)
        self.refinement = Refinement(self._settings, self.results, self.jobs)
        self.results.on_shown = self.refinement.refine
        self._coming_back = self._restore(settings)
        self._open()
        self.mesh_queue.start()
        self.jobs.start()

    def _settings(self) -> Settings:
        return self.table.settings

    def _open(self) -> None:
        """Topics, services, action and diagnostics."""
        requests = Requests(self._settings, self.results, self.mesh_queue, self.jobs,
                            self.refusals)
        MeshSubscriptions(self, self._settings, self.results, self.mesh_queue, self.refusals)
        self.counts = CountSubscription(self, self.recorder, self.parts.current, self.refusals)
        Services(self, self._settings, self.results, requests, self.refinement, self.jobs,
                 self.reports)
        self.action = SimulateDropsServer(self, requests, self.jobs, self.reports)
        steady_timer(self, SECONDS_BETWEEN, self.results.record_waiting,
                     MutuallyExclusiveCallbackGroup())
        Diagnostics(self, {
            "parts": lambda: self.refusals.health(len(self.parts.all()),
                                                  self.mesh_queue.waiting()),
            "jobs": lambda: job_health(self.jobs, self._settings()),
            "recording": self.recorder.health})

    def _on_change(self, settings: Settings) -> None:
        """Estimate known parts again, in the background."""
        self.parts.shrink(settings.max_parts)
        for known in self.parts.all():
            again = self.mesh_queue.put_later(partial(self.results.show_best, known))
            self.refusals.watch_mesh(lambda: "parameters", again)

    def _record_again(self) -> None:
        """Put on record what still counts and may be missing in the bag."""
        self.results.record_again()
        self.reports.record_again()

    def _restore(self, settings: Settings) -> list[Future[KnownPart]]:
        """Go on with what the last run left, and mend its bag once all of that is on record."""
        log = self.get_logger()
        run = last_run(bags_to_restore(settings.directory(), self.get_fully_qualified_name()))
        for bag, problem in run.problems.items():
            log.warning(f"not all of {bag.name} could be read: {problem}")
        end_unfinished_jobs(run, settings, self.jobs, self.recorder, log.warning)
        coming: list[Future[KnownPart]] = []
        if settings.restore and run.parts:
            coming = restore_parts(run, self.results, self.mesh_queue, self.refusals)
            log.info(f"restoring {len(run.parts)} parts of the last run")
        self.recorder.sync()
        self.recorder.mend_bags()
        return coming

    def restored(self, timeout: float) -> bool:
        """Wait for the parts of the last run; whether they are all there."""
        return not wait(self._coming_back, timeout).not_done

    def close(self) -> None:
        """End jobs and goals, and finish the bag; what was done is kept."""
        self.mesh_queue.close()
        self.jobs.close("the node ended")
        self.action.wait_until_told()
        self.late_answers.close()
        self.counts.take_waiting()
        self.results.record_waiting()
        self.recorder.close()
        if self.recorder.log.bytes_written or self.recorder.log.directory.is_dir():
            self.get_logger().info(f"recorded to {self.recorder.log.directory}")
