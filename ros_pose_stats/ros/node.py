"""The node `pose_stats`: wiring only."""

import threading
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

from . import camera_counts, parameters, recorder, refusals, restore
from .jobs import Jobs, job_reports, queue, refinement, run
from .messages.times import follow_clock, steady_timer
from .parts import announcer, checks, count_store, intake, outlines, part_builder
from .parts.lanes import Lanes
from .parts.part_store import PartStore
from .parts.result_store import SECONDS_BETWEEN, ResultStore
from .services import goals, plate_fits, services
from .services.feeding import FeedingService
from .services.requests import Requests
from .settings import Settings
from .state import State
from .transport.answering_node import AnsweringNode

PARTING_SECONDS = 0.1  # nobody has been answered for so long when the node stops answering
LAST_SECONDS = 0.6  # requests that wait for their turn when the node ends are refused in that time
FIT_SECONDS = 0.8  # a fit may be ended for so long when the node ends
MENDING_SECONDS = 1.0  # a start waits for the bags of earlier runs to be mended for so long


class PoseStatsNode(AnsweringNode):
    """Takes meshes, answers with stable poses and their probabilities, drops parts.

    Nothing is computed before `start`. Raises PoseStatsError if a parameter is refused, or the
    state file is in use, or of a newer version.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("pose_stats", **options)
        follow_clock(self.get_clock())
        self.table = parameters.Parameters(self, self._on_change)
        settings, log, name = self._settings(), self.get_logger(), self.get_fully_qualified_name()
        self.state = State(settings.state_path(name), restore.definitions(),
                           restore.as_of_today, log.warning)
        self.recorder = recorder.Recorder(settings, name, self.state, log.warning)
        tail = restore.tail_of(self.state, log.warning)
        ended, cancelled = restore.restore_jobs(self.state, tail, settings)
        self.refusals = refusals.Refusals(log.warning)
        self.lanes = Lanes(lambda: self._settings().max_mesh_bytes)
        self.builder = part_builder.PartBuilder(self._settings, self.lanes)
        self.outlines = outlines.Outlines(self.lanes)
        self.announcer = announcer.Announcer(self, self.recorder, self.state, self.refusals.floods)
        self.parts = PartStore(self._settings, self.recorder, self.state, self.announcer,
                               self.builder)
        self.cell_counts = count_store.CountStore(self._settings, self.parts, self.state)
        self.results = ResultStore(self._settings, self.parts, self.cell_counts, self.announcer,
                                   self.state)
        self.reports = job_reports.JobReports(self.results, self.parts, self.announcer,
                                              self.recorder, self.state, log.info)
        run_name = self.recorder.log.directory.name.removeprefix("pose_stats_")
        self.jobs = Jobs(run_name, self.reports, log.error)
        self.jobs.add_ended(ended)
        # Goals may flip for minutes; the answers of ~/feeding do not wait for them, nor for drops.
        self.flip_reports = run.FlipReports(), run.FlipReports()
        flips, feeding = self.flip_reports
        self.flip_jobs = (Jobs(f"{run_name}_flips", flips, log.error, run.run_flips),
                          Jobs(f"{run_name}_feeding", feeding, log.error, run.run_flips))
        self.refinement = refinement.Refinement(self._settings, self.results, self.jobs,
                                                self.announcer)
        self.checks = checks.Checks(self._settings, self.parts, self.results, self.lanes,
                                    self.refinement.refine, log.error)
        self.intake = intake.Intake(self._settings, self.parts, self.results, self.announcer,
                                    self.lanes, self.builder, self.refusals,
                                    self.checks.follow, log)
        self.counts = camera_counts.CountSubscription(self, self.recorder, self.parts,
                                                      self.refusals, self.announcer, self.cell_counts)
        if settings.restore:
            self.parts.restore()
            for known in self.parts.all():
                self.results.restore(known)
            for counts in tail.counts:
                self.counts.learn_counts(counts, again=True)
        else:
            restore.begin_afresh(self.state)
        self.recorder.note_place()
        self.state.commit()  # before cameras are heard, so that what the bag has is learnt
        restore.record_cancelled(cancelled, self.recorder, self.state, log.warning)
        self._mending = threading.Thread(target=self.recorder.mend_bags, name="mend bags",
                                         daemon=True)
        self._open()

    def _settings(self) -> Settings:
        return self.table.settings

    def _open(self) -> None:
        """Topics, services, actions and diagnostics."""
        self.requests = requests = Requests(self._settings, self.parts, self.intake, self.jobs,
                                            self.refusals)
        intake.MeshSubscriptions(self, self._settings, self.intake, self.refusals)
        self.observed = camera_counts.ObservedSubscription(self, self._settings, self.counts,
                                                           self.parts, self.recorder,
                                                           self.refusals)
        services.Services(self, self._settings, self.parts, self.results, self.announcer, requests,
                          self.intake, self.checks, self.refinement, self.jobs, self.reports,
                          self.outlines)
        flips, feeding = zip(self.flip_jobs, self.flip_reports, strict=True)
        FeedingService(self, self._settings, self.parts, *feeding, self.flip_reports[0])
        self.fits = plate_fits.PlateFits(self, self._settings, self.parts, self.cell_counts,
                                         self.announcer,
                                         self.table.use_plate)
        self.actions = [goals.SimulateDropsServer(self, requests, self.jobs, self.reports),
                        goals.SimulateFlipsServer(self, self._settings, self.parts, *flips)]
        steady_timer(self, SECONDS_BETWEEN, self._write_down, MutuallyExclusiveCallbackGroup())
        refusals.Diagnostics(self, {
            "parts": lambda: self.refusals.health(len(self.parts.all()),
                                                  self.lanes.waiting()),
            "counts": lambda: count_store.count_health({known.part_id: known.counts
                                                        for known in self.parts.all()}),
            "jobs": lambda: queue.job_health(self.jobs, self._settings()),
            "flips": lambda: queue.flip_health(*self.flip_jobs),
            "recording": self.recorder.health})

    def start(self) -> None:
        """Latch what an earlier run has latched, and begin to work; kernels are loaded by now."""
        log, parts = self.get_logger(), self.parts.all()
        shown = {known.part_id: self.results.show_restored(known) for known in parts}
        self.cell_counts.take_new()  # what the last bag had is shown by that, or with the estimate
        if parts:
            log.info(f"{len(parts)} parts of an earlier run are known again")
        self._mending.start()
        self._mending.join(MENDING_SECONDS)
        self.lanes.start()
        for jobs in (self.jobs, *self.flip_jobs):
            jobs.start()
        self.intake.restore(shown)

    def _on_change(self, settings: Settings) -> None:
        """Estimate known parts again, in the background."""
        self.parts.shrink()
        self.intake.show_all_again()

    def _write_down(self) -> None:
        """Once a second: show what was counted, and have all on the disk."""
        self.results.show_waiting()
        self.parts.keep_uses()
        self.recorder.sync()

    def close(self) -> None:
        """End jobs and goals, and write all down; what was done is kept.

        Whoever waits for a part is told that the node ends. What does not end in its time is left
        as it is.
        """
        self.requests.close()
        self.builder.close()
        self.outlines.close()
        ends = [self.lanes.close, partial(self.answers.close, LAST_SECONDS),
                partial(self.fits.close, FIT_SECONDS),
                *(partial(jobs.close, "the node ended") for jobs in (self.jobs, *self.flip_jobs))]
        with ThreadPoolExecutor(len(ends)) as closing:  # each may take its time
            list(closing.map(lambda end: end(), ends))
        for action in self.actions:
            action.wait_for_clients()
        self.answers.wait_until_quiet(PARTING_SECONDS, LAST_SECONDS)
        self.announcer.close()
        self.observed.take_waiting()
        self.counts.take_waiting()
        self._write_down()
        self.save()

    def save(self) -> None:
        """Commit the state and finish the bag, whatever else goes on; may be called twice."""
        self.state.close()
        written = self.recorder.log.bytes_written
        self.recorder.close()
        if written:
            self.get_logger().info(f"recorded to {self.recorder.log.directory}")
