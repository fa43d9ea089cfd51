"""The node `pose_stats`: wiring only."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future, wait
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent, PartMesh, PoseCounts
from shape_msgs.msg import Mesh

from ..errors import PoseStatsError
from ..recording.repair.repair import repair_bags
from .diagnostics import Diagnostics, Refusals, status
from .jobs import Jobs
from .jobs.job_reports import JobReports, job_event
from .jobs.simulate_drops import SimulateDropsServer
from .messages.part_lines import count_problem, counts_of_bytes, named, part_line
from .messages.part_messages import request_of_mesh_bytes, request_of_part_bytes
from .messages.times import now, time_message
from .parameters import Parameters
from .parts.catalogue import KnownPart
from .parts.latching import LatchedPublishers
from .parts.marker_publisher import MarkerPublisher
from .parts.mesh_queue import MeshQueue
from .parts.mesh_topics import mesh_topics
from .parts.part_requests import PartRequest, plain
from .parts.refinement import Refinement
from .parts.results import Results
from .recorder import JOB_EVENTS, POSE_COUNTS, Recorder, said
from .requests import Requests
from .restart.bag_choice import bags_to_restore
from .restart.interrupted import interrupted_job
from .restart.restore import LastRun, last_run
from .services import Services
from .settings import Settings
from .transport.late_answers import PatientNode
from .transport.overruns import SequenceGaps

DEPTH = 100


class PoseStatsNode(PatientNode):
    """Takes meshes, answers with stable poses and their probabilities, drops parts.

    Raises
    ------
    PoseStatsError
        If a parameter is refused.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("pose_stats", **options)
        self.table = Parameters(self, self._on_change)
        settings = self._settings()
        say = self.get_logger()
        self.refusals = Refusals()
        self.recorder = Recorder(settings, self.get_fully_qualified_name(), say.warning,
                                 self._record_again)
        self.results = Results(self._settings, self.recorder,
                               LatchedPublishers(self, "~/pose_statistics"), self._on_part,
                               self._on_new_part, lambda: self.markers.touch())
        self.mesh_queue = MeshQueue(lambda: 2 * self._settings().max_mesh_bytes)
        self.reports = JobReports(self.results, self.recorder, say.info)
        self.jobs = Jobs(self.recorder.log.directory.name.removeprefix("pose_stats_"),
                         self.reports, say.error)
        self.requests = Requests(self._settings, self.results, self.mesh_queue, self.jobs,
                                 self._refuse)
        self.refinement = Refinement(self._settings, self.results, self.jobs)
        self.markers = MarkerPublisher(self, self.results)
        self._coming_back: list[Future[KnownPart]] = []
        self._restore(settings)
        self._open(settings)
        self.mesh_queue.start()
        self.jobs.start()

    def _settings(self) -> Settings:
        return self.table.settings

    def _open(self, settings: Settings) -> None:
        """Topics, services, action and timers."""
        meshes = MutuallyExclusiveCallbackGroup()
        self._subscribe(PartMesh, "~/part_mesh", meshes, request_of_part_bytes)
        for part_id, topic in mesh_topics(settings.mesh_topics).items():
            self._subscribe(Mesh, topic, meshes, self._taker(part_id))
        self.create_subscription(PoseCounts, "~/pose_counts", self._count, DEPTH, raw=True,
                                 callback_group=MutuallyExclusiveCallbackGroup())
        self.services_of_node = Services(self, self._settings, self.results, self.requests,
                                         self.refinement, self.jobs, self.reports,
                                         self._note_forgotten)
        self.action = SimulateDropsServer(self, self.requests, self.jobs, self.reports)
        health = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        diagnostics = Diagnostics(
            (self._mesh_status, self._job_status, self._recording_status), health.publish)
        self.create_timer(1.0, diagnostics.tick, callback_group=MutuallyExclusiveCallbackGroup())

    def _taker(self, part_id: str) -> Callable[[bytes], PartRequest]:
        return lambda data: request_of_mesh_bytes(data, part_id, self._settings().mesh_unit)

    def _subscribe(self, kind: type, topic: str, group: MutuallyExclusiveCallbackGroup,
                   take: Callable[[bytes], PartRequest]) -> None:
        """Plain and latched publishers both arrive; a copy is ignored later."""
        def on_mesh(data: bytes) -> None:
            source = [topic]

            def work() -> KnownPart:
                request = take(data)
                source[0] += named(request.part_id)
                return self.results.take(request)

            future = self.mesh_queue.put(work, len(data))
            future.add_done_callback(lambda done: self._look(source[0], done))

        gaps = SequenceGaps()

        def on_counted_mesh(data: bytes, info: Mapping[str, int]) -> None:
            self.refusals.lose(gaps.missing_before(info["publication_sequence_number"] or 0))
            on_mesh(data)

        plain = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE,
                           durability=DurabilityPolicy.VOLATILE)
        latched = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE,
                             durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(kind, topic, on_counted_mesh, plain, raw=True,
                                 callback_group=group)
        # Plain publishers do not match this one; what else is wrong with a publisher, the
        # plain subscription warns of.
        self.create_subscription(
            kind, topic, on_mesh, latched, raw=True, callback_group=group,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=lambda info: None))

    def _look(self, topic: str, done: Future[Any]) -> None:
        error = None if done.cancelled() else done.exception()
        if isinstance(error, PoseStatsError):
            self._refuse(topic, str(error))
        elif error is not None:
            self._refuse(topic, f"internal failure: {type(error).__name__}: {error}")

    def _record_again(self) -> None:
        self.mesh_queue.put_later(self.results.record_again)

    def _refuse(self, source: str, reason: str, what: str = "mesh") -> None:
        if self.refusals.refuse(source, reason):
            self.get_logger().warning(f"{source}: {what} refused: {reason}")

    def _on_part(self, known: KnownPart) -> None:
        self.refinement.refine(known)

    def _on_new_part(self, known: KnownPart) -> None:
        """Say what has come, so that a wrong unit is seen at once."""
        self.get_logger().info(part_line(known.part, known.latched))
        for warning in known.part.warnings:
            self.get_logger().warning(f"{known.part.part_id}: {warning}")

    def _count(self, data: bytes) -> None:
        """Record a count as it is; say if it cannot be compared with anything."""
        try:
            counts = counts_of_bytes(data)
        except PoseStatsError as refusal:  # in the bag it would be in the way of its readers
            self._refuse("~/pose_counts", str(refusal), "count")
            return
        self.recorder.record(POSE_COUNTS, data, durable=True)
        problem = count_problem(counts, self.results.parts.current)
        if problem:
            self.get_logger().warning(f"~/pose_counts: recorded, but {problem}")

    def _note_forgotten(self, part_id: str, digest: str) -> None:
        event = JobEvent(event=JobEvent.PART_FORGOTTEN, part_id=part_id, part_digest=digest)
        event.header.stamp = time_message(now())
        self.recorder.record(JOB_EVENTS, serialize_message(event), durable=True)

    def _on_change(self, settings: Settings) -> None:
        """Estimate known parts again, in the background."""
        self.results.parts.shrink(settings.max_parts)
        for known in self.results.parts.all():
            again = self.mesh_queue.put_later(partial(self.results.refresh, known))
            again.add_done_callback(partial(self._look, "parameters"))

    def _restore(self, settings: Settings) -> None:
        """Put on record what the last run left unfinished or is to go on, and mend its bag."""
        run = last_run(bags_to_restore(settings.directory(),
                                       self.get_fully_qualified_name()))
        for bag, problem in run.problems.items():
            self.get_logger().warning(f"not all of {bag.name} could be read: {problem}")
        self._log_unfinished(run, settings)
        if settings.restore:
            for part_id, request in run.parts.items():
                last = self.results.take_over(request, run.latched(part_id))
                self._bring_back(request, last)
            if run.parts:
                self.get_logger().info(f"restoring {len(run.parts)} parts of the last run")
        self.recorder.sync()
        self.repairs = [said(repair) for repair in repair_bags(settings.directory())]
        for repair in self.repairs:
            self.get_logger().warning(repair)

    def _log_unfinished(self, run: LastRun, settings: Settings) -> None:
        jobs = [interrupted_job(event, settings) for event in run.unfinished.values()]
        for job in jobs:
            event = job_event(job, JobEvent.CANCELLED, job.message)
            self.recorder.record(JOB_EVENTS, serialize_message(event), durable=True)
            self.get_logger().warning(f"{plain(job.job_id)}: CANCELLED: {job.message}")
        self.jobs.add_ended(jobs)

    def _bring_back(self, request: PartRequest, latched: Any) -> None:
        future = self.mesh_queue.put_later(lambda: self.results.take(request, latched))
        future.add_done_callback(partial(self._look, "restored part"))
        self._coming_back.append(future)

    def restored(self, timeout: float) -> bool:
        """Wait for the parts of the last run; whether they are all there."""
        return not wait(self._coming_back, timeout).not_done

    def _mesh_status(self) -> DiagnosticStatus:
        return self.refusals.status(self._line("parts"), len(self.results.parts.all()),
                                    self.mesh_queue.waiting())

    def _line(self, about: str) -> str:
        """Name of a line in diagnostics."""
        return f"{self.get_fully_qualified_name()[1:]}: {about}"

    def _job_status(self) -> DiagnosticStatus:
        asked, refinements = self.jobs.counts()
        job = self.jobs.running
        text = "idle" if job is None else (
            f"{job.job_id}: {job.drops_done} of {job.request.drops} drops of "
            f"'{job.part_id}'")
        return status(self._line("jobs"), False, text, {
            "queued": asked, "refinements queued": refinements,
            "queue bound": self._settings().max_queued_jobs,
            "running": "" if job is None else job.job_id,
            "threads": self._settings().threads()})

    def _recording_status(self) -> DiagnosticStatus:
        problem = self.recorder.problem
        values = self.recorder.state()
        values["last repair"] = self.repairs[-1] if self.repairs else "none"
        text = f"NOT_RECORDED: {problem}" if problem else "recording"
        if not problem and self.recorder.log.over_bound:
            text = "this run alone is larger than max_log_bytes; nothing of it is deleted"
        return status(self._line("recording"), text != "recording", text, values)

    def close(self) -> None:
        """End jobs and goals, and finish the bag; what was done is kept."""
        self.mesh_queue.close()
        self.jobs.close("the node ended")
        self.action.wait_until_told()
        self.late_answers.close()
        self.recorder.close()
        if self.recorder.log.bytes_written or self.recorder.log.directory.is_dir():
            self.get_logger().info(f"recorded to {self.recorder.log.directory}")
