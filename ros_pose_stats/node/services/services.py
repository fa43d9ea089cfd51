# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Service callbacks: a request in, a response out, refusals as messages."""

from concurrent.futures import Future, wait
from functools import partial
from typing import Any

from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.msg import Code, JobEvent, PoseStatistics

from ...base import errors, methods, text
from ...core.mesh import mass_properties
from ...core.records import Array, Part
from ...core.records.notes import note
from ...core.resting.silhouettes import find_lookalikes
from ...core.simulation.request import check_target
from ..answering_node import Steps, result_of
from ..equipment import Equipment
from ..jobs import Job, JobRequest, Jobs, State, job_reports
from ..jobs.refinement import Refinement
from ..lanes import Rank, finished_future, result_or_refusal
from ..messages import part_messages, part_requests, statistics_messages
from ..messages.codes import NotFoundError, refusal_at_end
from ..parts import part_builder
from ..parts.intake import Intake
from ..parts.known_part import KnownPart
from ..parts.registry import PartRegistry
from ..recorder import ANSWERS

BY_DROPS = "ask for the method auto, or start a drop simulation"
AS_ITSELF = "for drops, send the part with this centre of mass in its inertia"
"""What to do about an estimate that misses its target."""

CANCEL_PATIENCE = 0.06  # seconds that a cancel waits for the simulation's end
# Seconds that a start waits for a small part, which may be refused.
START_PATIENCE = 0.004
QUICK_TRIANGLES = 1000  # most of such a part


class Services:
    """All services about parts and drop simulations."""

    def __init__(
        self,
        equipment: Equipment,
        parts: PartRegistry,
        intake: Intake,
        refinement: Refinement,
        jobs: Jobs,
        reports: job_reports.JobReports,
        outlines: part_builder.Outlines,
    ) -> None:
        self._settings = equipment.settings
        self._intake = intake
        self._equipment = equipment
        self._parts = parts
        self._refinement = refinement
        self._outlines = outlines
        self._jobs = jobs
        self._reports = reports
        for kind, name, callback in (
            (srv.EstimatePoses, "estimate", self.estimate),
            (srv.StartDropSimulation, "start_drop_simulation", self.start_simulation),
            (srv.GetStatistics, "get_statistics", self.get_statistics),
            (srv.ForgetPart, "forget_part", self.forget_part),
            (srv.GetDropSimulation, "get_drop_simulation", self.get_job),
            (srv.ListDropSimulations, "list_drop_simulations", self.list_jobs),
            (srv.CancelDropSimulation, "cancel_drop_simulation", self.cancel_job),
        ):
            equipment.node.serve(kind, name, callback)

    def _find_part(
        self, request: Any
    ) -> tuple[Future[KnownPart], KnownPart | part_requests.PartRequest]:
        """The part of a request, on its way, and as far as it is there.

        A known part may not be built yet; the message of a sent one is emptied.
        """
        if self._equipment.lanes.is_closed:
            raise refusal_at_end()
        message = request.part
        if request.part_id and message.part_id and request.part_id != message.part_id:
            part_ids = " and ".join(
                map(part_requests.quote_text, (request.part_id, message.part_id))
            )
            raise errors.RequestError(
                "the same part_id in the request and in its part",
                part_ids,
                "fill one of the two",
            )
        part_id = message.part_id = message.part_id or request.part_id
        if not part_messages.has_mesh(message):
            part = self._parts.require(part_id)
        else:
            known_part = self._parts.find(part_id) if part_id else None
            source = f"request for {part_requests.quote_text(part_id)}"
            try:
                mesh = part_messages.take_request(
                    message, self._equipment.node.full_name("part_mesh")
                )
                part_requests.check_request(mesh, self._settings().max_mesh_bytes)
                self._settings().scene(mesh.scene_override)
            except errors.PoseStatsError as refusal:
                self._equipment.refusals.refuse(source, str(refusal))
                raise
            if (
                known_part is None
                or known_part.content != mesh.content
                or known_part.scene_override != mesh.scene_override
            ):
                return self._intake.queue(mesh, source, Rank.REQUESTED_MESH), mesh
            part = known_part
        return finished_future(part), part

    def estimate(self, request: Any, response: Any) -> Steps[None]:
        """An analytic answer; one by `auto` is checked by drops, or refined by them."""
        check_target(request.target_error)
        step = request.com_offset
        offset = mass_properties.check_offset((step.x, step.y, step.z))
        future_part, mesh = self._find_part(request)
        part = sent_part = yield from result_of(future_part)
        scene = self._settings().scene(
            (request.restitution, request.drop_height), mesh.scene_override
        )
        # Who has these has the parts in memory until they are answered.
        builds: list[Future[Part]] = []
        if offset.any():
            builds.append(self._intake.build_known(sent_part))
            yield from result_of(builds[-1])
            part = self._parts.shift(sent_part, offset)
        if request.target_error or not self._refinement.has_answer(
            part, request.method, scene
        ):
            builds.append(self._intake.build_known(part, scene))
            yield from result_of(builds[-1])
        is_auto = (request.method or self._settings().default_method) == methods.AUTO
        if is_auto and not request.target_error:
            checked = yield from result_of(self._refinement.check(part, scene))
            message, response.message = self._refinement.answer_checked(
                part, checked, scene
            )
        elif is_auto and part is sent_part:
            checked = yield from result_of(self._refinement.check(part, scene))
            message, response.message = self._refinement.answer(
                part, checked, request.target_error, scene
            )
        else:
            # Drops in the background would be of the part as it is known.
            message = self._refinement.answer_by(
                request.method,
                part,
                request.target_error,
                scene,
                BY_DROPS if part is sent_part else AS_ITSELF,
            )
        if part is not sent_part:
            message = _warn_of_shift(message, offset)
        if not sent_part.is_stored():
            message = self._equipment.warn_unrecorded(message)
        message = yield from result_of(
            sent_part.once_introduced(partial(sent_part.record, ANSWERS, message))
        )
        if not statistics_messages.is_recorded(message):
            response.code = Code.NOT_RECORDED
        response.statistics = message

    def start_simulation(self, request: Any, response: Any) -> None:
        """Queue a drop simulation."""
        job = self.start_job(request)
        response.job_id = job.job_id
        if not job.is_recorded:
            self._equipment.say_unrecorded(response)

    def start_job(self, request: Any) -> Job:
        """Accept a drop simulation out of a `StartDropSimulation` or a goal."""
        settings = self._settings()
        drops = request.drops or min(settings.drops, settings.max_drops)
        if drops > settings.max_drops:
            raise errors.RequestError(
                f"at most {settings.max_drops} drops (parameter max_drops)",
                f"{drops}",
                "ask for fewer, or raise the parameter",
            )
        check_target(request.target_error)
        max_seconds = settings.max_job_seconds
        seconds = request.max_seconds or max_seconds
        if not 0.0 < seconds <= max_seconds:
            raise errors.RequestError(
                f"max_seconds from 0 to {max_seconds:g} s (parameter max_job_seconds)",
                f"{request.max_seconds:g} s",
                "0 stands for the node's",
            )
        future_part, mesh = self._find_part(request)
        if isinstance(mesh, KnownPart):
            future_part = self._intake.build_for_job(mesh)
        if isinstance(mesh, KnownPart) or len(mesh.triangles) <= QUICK_TRIANGLES:
            wait([future_part], START_PATIENCE)
        if future_part.done():
            result_or_refusal(future_part)
        scene = settings.scene(
            (request.restitution, request.drop_height), mesh.scene_override
        )
        return self._jobs.submit(
            JobRequest(
                mesh.part_id,
                mesh.content,
                scene,
                drops,
                request.seed,
                request.target_error,
                seconds,
            ),
            future_part,
            settings,
        )

    def get_statistics(self, request: Any, response: Any) -> Steps[None]:
        """What is latched, with outlines of one part where they are asked for."""
        parts = self._parts
        if request.heights and not request.part_id:
            raise errors.RequestError(
                "a part_id with heights", "none", "ask for one part's outlines"
            )
        chosen_parts = (
            [parts.require(request.part_id)] if request.part_id else parts.all()
        )
        results = [part.latched for part in chosen_parts if part.latched is not None]
        response.statistics = [result.message for result in results]
        if request.heights and results:
            geometry = yield from result_of(self._intake.build_known(chosen_parts[0]))
            message = results[0].message
            response.outlines = yield from result_of(
                self._outlines.begin(geometry, message, request.heights)
            )
            if min(request.heights) < 0.0:
                seen = yield from result_of(
                    self._outlines.put(
                        geometry,
                        "silhouettes",
                        find_lookalikes,
                        statistics_messages.statistics_of_message(message),
                        geometry,
                    )
                )
                response.statistics = [
                    statistics_messages.with_lookalikes(message, seen)
                ]

    def forget_part(self, request: Any, response: Any) -> None:
        """Forget a part."""
        if not self._parts.forget(self._parts.require(request.part_id)):
            self._equipment.say_unrecorded(response)

    def get_job(self, request: Any, response: Any) -> None:
        """How far a job is."""
        job, event = self._look_up(request.job_id)
        response.message = event.message
        response.status = event.status
        response.statistics = self._reports.answer_of(request.job_id, job)

    def list_jobs(self, request: Any, response: Any) -> None:
        """All jobs."""
        present = {job.job_id: job_reports.job_event(job) for job in self._jobs.all()}
        events = self._reports.ends | present
        response.jobs = sorted(
            (event.status for event in events.values()),
            key=lambda status: job_reports.acceptance(status.job_id),
        )

    def cancel_job(self, request: Any, response: Any) -> None:
        """Cancel a job; what was done is kept."""
        job, event = self._look_up(request.job_id)
        if job is None:
            raise NotFoundError(
                "the job_id of a drop simulation that has not ended",
                f"{event.status.job_id}, which is {State(event.status.state).name}",
                "get_drop_simulation has its results",
            )
        self._jobs.cancel(job.job_id, "cancelled by a client")
        wait([job.finished], CANCEL_PATIENCE)

    def _look_up(self, job_id: str) -> tuple[Job | None, JobEvent]:
        """A job, unless it has ended, and its last event, also of earlier runs."""
        job = self._jobs.get(job_id)
        event = (
            self._reports.ends.get(job_id)
            if job is None
            else job_reports.job_event(job)
        )
        if event is None:
            raise NotFoundError(
                "the job_id of a drop simulation",
                part_requests.quote_text(job_id),
                "list_drop_simulations lists those that the node knows",
            )
        return job, event


def _warn_of_shift(message: PoseStatistics, offset: Array) -> PoseStatistics:
    """A result that says that it is of a part with another centre of mass."""
    shift = text.listed([text.millimetres(x) for x in offset.tolist()])
    return statistics_messages.with_warning(
        message,
        note(
            "COM_SHIFTED",
            f"the centre of mass is shifted by {shift} mm along the part's axes, the "
            "inertia about it stays; what is latched is of the part as it was sent.",
        ),
    )
