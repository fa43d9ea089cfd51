"""The node `pose_stats`: wiring only."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import partial
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

from .diagnostics import Diagnostics, Refusals, flip_health, job_health
from .feeding import FeedingService
from .jobs import Jobs
from .jobs.flips import FlipReports, run_flips
from .jobs.job_reports import JobReports
from .jobs.plate_fits import PlateFits
from .jobs.simulate_drops import SimulateDropsServer
from .jobs.simulate_flips import SimulateFlipsServer
from .messages.times import follow_clock, steady_timer
from .observed_parts import ObservedSubscription
from .parameters import Parameters
from .parts.announcer import Announcer
from .parts.cell_counts import count_health
from .parts.mesh_queue import MeshQueue
from .parts.mesh_subscriptions import MeshSubscriptions
from .parts.outlines import Outlines
from .parts.part_builder import PartBuilder, is_large
from .parts.part_store import KnownPart, PartStore
from .parts.refinement import Refinement
from .parts.result_store import SECONDS_BETWEEN, ResultStore
from .pose_counts import CountSubscription
from .recorder import Recorder
from .requests import Requests
from .restart.earlier_runs import earlier_runs
from .restart.handover import Handover, RunsInUse
from .restart.last_run import last_run
from .restart.restore import (
    end_unfinished_jobs,
    parts_to_restore,
    records_to_come,
    restore_parts,
)
from .services import Services
from .settings import Settings
from .transport.answering_node import AnsweringNode

PARTING_SECONDS = 0.2
"""Nobody has been answered for so long when the node stops answering."""

LAST_SECONDS = 0.5
"""Requests that wait for their turn when the node ends are refused in that time."""

FIT_SECONDS = 0.2
"""A fit may be ended for so long when the node ends."""


class PoseStatsNode(AnsweringNode):
    """Takes meshes, answers with stable poses and their probabilities, drops parts.

    Raises PoseStatsError if a parameter is refused.
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
        self.builder = PartBuilder()
        self.outlines = Outlines()
        self.parts.build = lambda request: self.builder.build(
            request, self._settings().scene(), self.mesh_queue.is_quick())
        self.results = ResultStore(self._settings, self.parts, self.announcer)
        self.mesh_queue = MeshQueue(lambda: self._settings().max_mesh_bytes)
        self.reports = JobReports(self.results, self.recorder, log.info)
        self.recorder.on_gap = self._record_again
        run_name = self.recorder.log.directory.name.removeprefix("pose_stats_")
        self.jobs = Jobs(run_name, self.reports, log.error)
        # Goals may flip for minutes; the answers of ~/feeding do not wait for them, nor for drops.
        self.flip_reports = FlipReports(), FlipReports()
        flips, feeding = self.flip_reports
        self.flip_jobs = (Jobs(f"{run_name}_flips", flips, log.error, run_flips),
                          Jobs(f"{run_name}_feeding", feeding, log.error, run_flips))
        self.refinement = Refinement(self._settings, self.results, self.jobs)
        self.results.on_shown = self.refinement.refine
        self._coming_back = self._restore(settings)
        self._open()
        self.mesh_queue.start()
        for jobs in (self.jobs, *self.flip_jobs):
            jobs.start()

    def _settings(self) -> Settings:
        return self.table.settings

    def _open(self) -> None:
        """Topics, services, action and diagnostics."""
        self.requests = requests = Requests(
            self._settings, self.results, self.mesh_queue, self.jobs, self.refusals,
            self.builder.find_poses)
        MeshSubscriptions(self, self._settings, self.results, self.mesh_queue, self.refusals)
        self.counts = CountSubscription(self, self.recorder, self.parts.current, self.refusals,
                                        self.results.add_counts)
        self.observed = ObservedSubscription(self, self._settings, self.counts,
                                             self.parts.current, self.recorder, self.refusals)
        Services(self, self._settings, self.results, requests, self.refinement, self.jobs,
                 self.reports, self.outlines)
        flips, feeding = zip(self.flip_jobs, self.flip_reports, strict=True)
        FeedingService(self, self._settings, self.parts, *feeding, self.flip_reports[0])
        self.fits = PlateFits(self, self._settings, self.parts, self.table.use_plate)
        self.actions = [SimulateDropsServer(self, requests, self.jobs, self.reports),
                        SimulateFlipsServer(self, self._settings, self.parts, *flips)]
        steady_timer(self, SECONDS_BETWEEN, self.results.record_waiting,
                     MutuallyExclusiveCallbackGroup())
        Diagnostics(self, {
            "parts": lambda: self.refusals.health(len(self.parts.all()),
                                                  self.mesh_queue.waiting()),
            "counts": lambda: count_health({known.part.part_id: known.counts
                                            for known in self.parts.all()}),
            "jobs": lambda: job_health(self.jobs, self._settings()),
            "flips": lambda: flip_health(*self.flip_jobs),
            "recording": self.recorder.health})

    def _on_change(self, settings: Settings) -> None:
        """Estimate known parts again, in the background."""
        self.parts.shrink(settings.max_parts, settings.max_part_bytes)
        for known in self.parts.all():
            again = self.mesh_queue.put_later(partial(self._show_again, known),
                                              is_large(known.part))
            self.refusals.watch_mesh(lambda: "parameters", again)

    def _show_again(self, known: KnownPart) -> None:
        self.builder.find_poses(known.part, self._settings().scene())
        self.results.show_best(known)

    def _restore(self, settings: Settings) -> list[Future[KnownPart]]:
        """Go on with what earlier runs left, and mend their bags once that is on record."""
        log, folder = self.get_logger(), settings.directory()
        earlier = earlier_runs(folder, self.get_fully_qualified_name())
        run = last_run(earlier.bags, settings.max_parts)
        for bag, problem in run.problems.items():
            log.warning(f"not all of {bag.name} could be read: {problem}")
        records = end_unfinished_jobs(run, settings, self.jobs, log.warning)
        parts = parts_to_restore(run, self.results) if settings.restore else []
        self._restored_parts = parts
        self.handover = Handover(self.recorder, earlier, [
            *records, *(record for part in parts for record in part.records())])
        self.recorder.before_record = self.handover.settle
        self.recorder.log.keep_runs(RunsInUse(
            self.handover, self.parts.meshes, self.recorder.have_recorded_again))
        coming = restore_parts(parts, folder, self.results, self.mesh_queue, self.refusals)
        if parts:
            log.info(f"restoring {len(parts)} parts of the last run")
        if records or run.problems or not earlier.settled or any(one.changed for one in parts):
            self.handover.settle()
        self.recorder.mend_bags()
        return coming

    def _record_again(self) -> None:
        """Put on record what still counts and may be missing in the bag.

        Only then does it say again that nothing else is to be taken from earlier runs.
        """
        lost = self.recorder.lost
        self.results.record_again()
        self.reports.record_again()
        if self.recorder.lost == lost:
            self.handover.repeat(records_to_come(self._restored_parts, self.parts))

    def restored(self, timeout: float) -> bool:
        """Wait for the parts of the last run; whether they are all there."""
        return not wait(self._coming_back, timeout).not_done

    def close(self) -> bool:
        """End jobs and goals, and finish the bag; what was done is kept.

        Whoever waits for a part is told that the node ends.

        Returns whether nothing is computed any more.
        """
        self.requests.close()
        self.builder.close()
        self.outlines.close()
        at_rest = self.mesh_queue.close()
        at_rest = self.answers.close(LAST_SECONDS) and at_rest
        queues = (self.jobs, *self.flip_jobs)
        with ThreadPoolExecutor(len(queues)) as closing:  # each may take its time to end
            ended = list(closing.map(lambda jobs: jobs.close("the node ended"), queues))
        at_rest = all(ended) and at_rest
        at_rest = self.fits.close(FIT_SECONDS) and at_rest
        for action in self.actions:
            action.wait_until_told()
        self.answers.wait_until_quiet(PARTING_SECONDS, 2.0 * LAST_SECONDS)
        self.announcer.close()
        self.observed.take_waiting()
        self.counts.take_waiting()
        self.results.record_waiting()
        self.recorder.close()
        if self.recorder.log.bytes_written or self.recorder.log.directory.is_dir():
            self.get_logger().info(f"recorded to {self.recorder.log.directory}")
        return at_rest
