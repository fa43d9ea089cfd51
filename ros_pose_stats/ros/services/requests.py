"""From what clients ask to parts and jobs."""

import math
from collections.abc import Callable
from concurrent.futures import Future, wait
from typing import Any

from ...errors import PoseStatsError, RequestError
from ..base import Base
from ..jobs import Job, JobRequest, Jobs
from ..lanes import done_with, ending, result_of
from ..messages import part_messages, part_requests
from ..parts.intake import Intake
from ..parts.known_part import KnownPart
from ..parts.result_store import Stores

PATIENCE = 0.004  # seconds that a start waits for a small part, which may be refused
QUICK_TRIANGLES = 1000  # most of such a part


class Requests:
    """Finds parts and starts jobs, for services and the action."""

    def __init__(self, base: Base, stores: Stores, intake: Intake, jobs: Jobs) -> None:
        self._settings, self._refusals = base.settings, base.refusals
        self._parts, self._intake, self._jobs = stores.parts, intake, jobs
        self._closed = False

    def close(self) -> None:
        """Refuse whatever comes from now on."""
        self._closed = True

    def find_part(self, part_id: str, message: Any,
                  is_enough: Callable[[KnownPart], bool] = lambda known: False
                  ) -> tuple[Future[KnownPart], KnownPart | part_requests.PartRequest]:
        """The part of a request, on its way, and as far as it is there; empties the message.

        `is_enough`: whether a known part will do though it is not built yet.
        """
        if self._closed:
            raise ending()
        carried = part_messages.is_given(message)
        if part_id and message.part_id and part_id != message.part_id:
            wanted, got = (
                ("the same part_id in the request and in its part", "{} and {}") if carried
                else ("one part", "part_id {} and part {}"))
            raise RequestError(wanted, got.format(part_requests.shown(part_id),
                                                  part_requests.shown(message.part_id)),
                               "fill one of the two")
        message.part_id = message.part_id or part_id
        if not carried:
            known = self._parts.known(message.part_id)
        else:
            same = self._parts.find(message.part_id) if message.part_id else None
            source = f"request for {part_requests.shown(message.part_id)}"
            try:
                request = part_messages.taken_request(message)
                part_requests.check_request(request, self._settings().max_mesh_bytes)
                self._settings().scene(request.scene_override)
            except PoseStatsError as refusal:
                self._refusals.refuse(source, str(refusal))
                raise
            if same is None or (same.content, same.scene_override) != (
                    request.content, request.scene_override):
                return self._intake.take_sent(request, source), request
            known = same
        return done_with(known) if is_enough(known) else self._intake.built(known), known

    def start_job(self, request: Any) -> Job:
        """Accept a drop simulation out of a `StartDropSimulation` or a goal."""
        settings = self._settings()
        drops = request.drops or min(settings.drops, settings.max_drops)
        if drops > settings.max_drops:
            raise RequestError(f"at most {settings.max_drops} drops (parameter max_drops)",
                               f"{drops}", "ask for fewer, or raise the parameter")
        check_target(request.target_error)
        seconds, most = request.max_seconds or settings.max_job_seconds, settings.max_job_seconds
        if not 0.0 < seconds <= most or math.isnan(seconds):
            raise RequestError(
                f"max_seconds from 0 to {most:g} s (parameter max_job_seconds)",
                f"{request.max_seconds:g} s", "0 stands for the node's")
        coming, mesh = self.find_part(request.part_id, request.part)
        if isinstance(mesh, KnownPart) or len(mesh.triangles) <= QUICK_TRIANGLES:
            wait([coming], PATIENCE)
        if coming.done():
            result_of(coming)
        scene = settings.scene((request.restitution, request.drop_height), mesh.scene_override)
        return self._jobs.submit(
            JobRequest(mesh.part_id, mesh.content, scene, drops, request.seed,
                       request.target_error, seconds), coming, settings)


def check_target(value: float) -> None:
    """Refuse a target error that is none; raises RequestError."""
    if not 0.0 <= value < 1.0:
        raise RequestError("a target_error from 0 to below 1, as a fraction", f"{value}",
                           "0.01 is one point; 0 stands for none")
