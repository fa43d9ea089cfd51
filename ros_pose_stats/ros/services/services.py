"""Service callbacks: a request in, a response out, refusals as messages."""

import math
from concurrent.futures import wait
from dataclasses import replace
from typing import Any

from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.msg import JobStatus, PoseStatistics

from ... import errors, methods
from ...mesh import mass_properties, parts as meshes
from ...planning.confidence import not_enough
from ...records import DropScene, Part
from ...text import listed, millimetres
from ..answering_node import Steps
from ..base import Base
from ..jobs import Job, Jobs, State, job_reports, refinement as refining
from ..messages import part_messages, part_requests, statistics_messages
from ..parts import known_part, part_builder, result_store
from ..parts.intake import Checks, Intake
from ..recorder import ANSWERS
from .requests import Requests, check_target

BY_DROPS = "ask for the method auto, or start a drop simulation"
AS_ITSELF = "for drops, send the part with this centre of mass in its inertia"
"""What to do about an estimate that misses its target."""

CANCEL_PATIENCE = 0.06  # seconds that a cancel waits for the simulation's end

class Services:
    """All services of the node."""

    def __init__(self, base: Base, stores: result_store.Stores, requests: Requests, intake: Intake,
                 checks: Checks, refinement: refining.Refinement, jobs: Jobs,
                 reports: job_reports.JobReports, outlines: part_builder.Outlines) -> None:
        self._settings, self._requests, self._intake = base.settings, requests, intake
        self._parts, _, self._results, self._announcer = stores
        self._checks, self._refinement = checks, refinement
        self._jobs, self._reports, self._outlines = jobs, reports, outlines
        self._shifted: known_part.Memory[Any, Part] = known_part.memory_of_parts()
        for kind, name, callback in (
                (srv.EstimatePoses, "estimate", self.estimate),
                (srv.StartDropSimulation, "start_drop_simulation", self.start),
                (srv.GetStatistics, "get_statistics", self.get_statistics),
                (srv.ForgetPart, "forget_part", self.forget),
                (srv.GetDropSimulation, "get_drop_simulation", self.get),
                (srv.ListDropSimulations, "list_drop_simulations", self.list),
                (srv.CancelDropSimulation, "cancel_drop_simulation", self.cancel)):
            base.node.serve(kind, f"~/{name}", callback, lambda request: not (  # meshes have lanes
                hasattr(request, "part") and part_messages.is_given(request.part)))

    def estimate(self, request: Any, response: Any) -> Steps:
        """An analytic answer; one that nobody chose is checked by drops, or refined by them."""
        check_target(request.target_error)
        step = request.com_offset
        offset = mass_properties.check_offset((step.x, step.y, step.z))

        def is_enough(known: known_part.KnownPart) -> bool:
            """Whether the answer is remembered since before the part was built in this run."""
            scene = self._settings().scene((request.restitution, request.drop_height),
                                           known.scene_override)
            return not (offset.any() or request.target_error) and self._results.remembers(
                known, request.method, scene)

        coming, mesh = self._requests.find_part(request.part_id, request.part, is_enough)
        known = received = yield coming
        if offset.any():
            key = received.part_id, received.digest, offset.tobytes()
            part = self._shifted.get(key) or meshes.shift_center(received.part, offset)
            self._shifted.put(key, part)
            known = replace(received, digest=part.digest, source=known_part.PartSource(part),
                            shown=None, counts=None)
        scene = self._settings().scene((request.restitution, request.drop_height),
                                       mesh.scene_override)
        yield self._intake.prepared(known, scene)
        is_auto = (request.method or self._settings().default_method) == methods.AUTO
        if is_auto and not request.target_error:
            checked = yield self._checks.begin(known, scene)
            message, response.message = self._refinement.answer_checked(known, checked, scene)
        elif is_auto and known is received:
            message, response.message = self._refinement.answer(known, request.target_error, scene)
        else:  # drops in the background would be of the part as it is known
            message = self._named(known, request, scene,
                                  BY_DROPS if known is received else AS_ITSELF)
        if known is not received:
            shift = listed([millimetres(x) for x in offset.tolist()])
            message = statistics_messages.with_warning(
                message, f"COM_SHIFTED: the centre of mass is shifted by {shift} mm along the "
                "part's axes, the inertia about it stays; what is latched is of the part as it "
                "was sent.")
        if not self._parts.is_kept(received):
            message = self._announcer.warn_unrecorded(message)
        response.statistics = self._announcer.record(ANSWERS, received, message)

    def _named(self, known: known_part.KnownPart, request: Any, scene: DropScene,
               advice: str) -> PoseStatistics:
        """An answer by the one estimator that was asked for, whatever its error."""
        message = self._results.estimate(known, request.method, scene)
        bound = 0.0
        if request.target_error:
            bound = refining.credible_bound(known.part, message, scene)
        if bound > request.target_error:
            short = f"the error of {message.method} is not known here"
            if math.isfinite(bound):
                short = not_enough(message.method, bound, request.target_error)
            message = statistics_messages.with_warning(
                message, f"TARGET_MISSED: {short}; {advice}.")
        return message

    def start(self, request: Any, response: Any) -> None:
        """Queue a drop simulation."""
        job = self._requests.start_job(request)
        response.job_id = job.job_id
        if not job.recorded:
            response.message = self._announcer.not_recorded()

    def get_statistics(self, request: Any, response: Any) -> Steps:
        """What is latched, with outlines of one part where they are asked for."""
        parts = self._parts
        if request.heights and not request.part_id:
            raise errors.RequestError("a part_id with heights", "none",
                                      "ask for one part's outlines")
        chosen = [parts.known(request.part_id)] if request.part_id else parts.all()
        latched = [shown.latched for known in chosen if (shown := known.shown) is not None]
        response.statistics = latched
        if request.heights and latched:
            response.outlines = yield self._outlines.begin(chosen[0].part, latched[0],
                                                           request.heights)

    def forget(self, request: Any, response: Any) -> None:
        """Forget a part."""
        known = self._parts.known(request.part_id)
        self._jobs.cancel_refinement(request.part_id, "the part was forgotten")
        if not self._parts.forget(known):
            response.message = self._announcer.not_recorded()

    def get(self, request: Any, response: Any) -> None:
        """How far a job is."""
        job = self._job(request.job_id)
        response.state = int(job.state)
        response.message = job.message
        response.drops_done, response.drops_total = job.drops_done, job.request.drops
        response.statistics = self._reports.current_answer(job)

    def list(self, request: Any, response: Any) -> None:
        """All jobs."""
        for job in self._jobs.all():
            response.job_id.append(job.job_id)
            response.part_id.append(job.part_id)
            response.state.append(int(job.state))
            response.drops_done.append(job.drops_done)
            response.drops_total.append(job.request.drops)
            response.jobs.append(JobStatus(
                job_id=job.job_id, part_id=job.part_id, state=int(job.state),
                drops_done=job.drops_done, drops_total=job.request.drops))

    def cancel(self, request: Any, response: Any) -> None:
        """Cancel a job; what was done is kept."""
        job = self._job(request.job_id)
        ended = job.state.ended
        self._jobs.cancel(request.job_id, "cancelled by a client")
        if ended:
            response.success = False
            response.message = f"{job.job_id} had ended before: {State(job.state).name}"
        else:
            wait([job.finished], CANCEL_PATIENCE)

    def _job(self, job_id: str) -> Job:
        job = self._jobs.get(job_id)
        if job is None:
            raise errors.RequestError("the job_id of a drop simulation",
                                      part_requests.shown(job_id),
                                      "list_drop_simulations lists those that the node knows")
        return job
