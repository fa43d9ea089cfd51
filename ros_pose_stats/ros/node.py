"""The node `pose_stats`: wiring only."""

import threading
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from . import camera_counts, restore
from .answering_node import AnsweringNode
from .base import Base
from .jobs import Jobs, job_reports, queue, refinement, run
from .lanes import Lanes
from .messages.times import follow_clock, steady_timer
from .parameters import Parameters
from .parts import announcer, count_store, intake, part_builder, part_store, result_store
from .recorder import Recorder
from .refusals import COUNTS, Refusals, publish_diagnostics
from .services import feeding, goals, plate_fits, services
from .settings import Settings
from .state import State

PARTING_SECONDS = 0.1  # nobody has been answered for so long when the node stops answering
LAST_SECONDS = 0.6  # requests that wait for their turn when the node ends are refused in that time
MENDING_SECONDS = 1.0  # a start waits for the bags of earlier runs to be mended for so long


class PoseStatsNode(AnsweringNode):
    """Takes meshes, answers with stable poses and probabilities; computes only after `start`."""

    def __init__(self, **options: Any) -> None:
        super().__init__("pose_stats", **options)
        follow_clock(self.get_clock())
        self.table = Parameters(self, self._on_change)
        settings, log, name = self._settings, self.get_logger(), self.get_fully_qualified_name()
        # What outlives the node, and what the last one left.
        self.state = state = State(settings().state_path(name), restore.definitions(),
                                   restore.as_of_today, log.warning)
        self.recorder = recorder = Recorder(settings(), name, state, log.warning)
        tail = restore.tail_of(state, log.warning)
        ended, cancelled = restore.restore_jobs(state, tail, settings())
        # Parts, and what is known of them.
        self.lanes = lanes = Lanes(lambda: settings().max_mesh_bytes)
        refusals = Refusals(log.warning)
        base = Base(self, settings, state, recorder, refusals, lanes)
        self.builder, self.outlines = part_builder.PartBuilder(base), part_builder.Outlines(base)
        self.board = board = announcer.Announcer(base)
        self.parts = parts = part_store.PartStore(base, board, self.builder)
        counts = count_store.CountStore(base, parts)
        self.results = results = result_store.ResultStore(base, parts, counts, board)
        stores = result_store.Stores(parts, counts, results, board)
        # Work in the background. Goals may flip for minutes: ~/feeding does not wait for them.
        reports = job_reports.JobReports(base, stores)
        prefix = recorder.log.directory.name.removeprefix("pose_stats_")
        self.jobs = jobs = Jobs(prefix, reports, log.error)
        jobs.add_ended(ended)
        flips = run.FlipReports()
        self.flip_jobs = (Jobs(f"{prefix}_flips", flips, log.error, run.run_flips),
                          Jobs(f"{prefix}_feeding", flips, log.error, run.run_flips))
        refiner = refinement.Refinement(base, stores, jobs)
        self.intake = intake.Intake(base, stores, self.builder, refiner.follow)
        # The way in; nothing is heard before the executor has the node.
        self.cameras = camera_counts.Cameras(base, stores)
        if settings().restore:
            parts.restore()
            for known in parts.all():
                results.restore(known)
            for message in tail.counts:
                self.cameras.learn_counts(message, again=True)
        else:
            restore.begin_afresh(state)
        recorder.note_place()
        state.commit()
        restore.record_cancelled(cancelled, recorder, state, log.warning)
        self._mending = threading.Thread(target=recorder.mend_bags, name="mend bags", daemon=True)
        intake.subscribe_to_meshes(base, self.intake)
        asked = services.Services(base, stores, self.intake, refiner, jobs, reports, self.outlines)
        feeding.FeedingService(base, stores, self.flip_jobs[1], flips)
        plate_fits.PlateFits(base, stores, self.table.use_plate)
        self.actions = [goals.SimulateDropsServer(base, asked, jobs, reports),
                        goals.SimulateFlipsServer(base, stores, self.flip_jobs[0], flips)]
        # Once a second.
        steady_timer(self, 1.0, self._write_down)
        publish_diagnostics(self, {
            "parts": lambda: refusals.health(len(parts.all()), lanes.waiting()),
            "counts": counts.health,
            "jobs": lambda: queue.job_health(jobs, settings()),
            "flips": lambda: queue.flip_health(*self.flip_jobs),
            "recording": lambda: recorder.health(refusals.lost[COUNTS])})

    def _settings(self) -> Settings:
        return self.table.settings

    def start(self) -> None:
        """Latch what an earlier run has latched, and begin to work; kernels are loaded by now."""
        log, parts = self.get_logger(), self.parts.all()
        shown = {known.part_id: self.results.show_restored(known) for known in parts}
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
        """End jobs and goals, and write all down; what does not end in its time is left so."""
        self.builder.close()
        self.outlines.close()
        ends = [self.lanes.close, partial(self.answers.close, LAST_SECONDS),
                *(partial(jobs.close, "the node ended") for jobs in (self.jobs, *self.flip_jobs))]
        with ThreadPoolExecutor(len(ends)) as closing:  # each may take its time
            list(closing.map(lambda end: end(), ends))
        for action in self.actions:
            action.wait_for_clients()
        self.answers.wait_until_quiet(PARTING_SECONDS, LAST_SECONDS)
        self.board.close()
        self.cameras.take_waiting()
        self._write_down()
        self.save()

    def save(self) -> None:
        """Commit the state and finish the bag, whatever else goes on; may be called twice."""
        self.state.close()
        written = self.recorder.log.bytes_written
        self.recorder.close()
        if written:
            self.get_logger().info(f"recorded to {self.recorder.log.directory}")
