"""From what clients ask to parts and jobs."""

import math
import threading
from collections.abc import Callable
from concurrent import futures
from concurrent.futures import CancelledError, Future
from typing import Any, NamedTuple, TypeVar

from ...errors import PoseStatsError, RequestError
from ...records import Part
from ..base import Base
from ..jobs import Job, JobRequest, Jobs
from ..messages import part_messages, part_requests
from ..parts.intake import Intake
from ..parts.known_part import KnownPart, at_hand
from ..parts.result_store import Stores

T = TypeVar("T")

PATIENCE = 0.004
"""Seconds that a start waits for a small part, so that most bad meshes are refused at once."""

QUICK_TRIANGLES = 1000
"""A larger carried mesh is begun with when the start of its simulation has been accepted."""


class ResolvedPart(NamedTuple):
    """The part of a request."""

    coming: Future[KnownPart]
    part_id: str
    # gives the digest of the mesh as it was sent, which takes a while for a large one
    content: Callable[[], bytes]
    scene_override: tuple[float, float]  # of the part's own scene; negative: the node's
    slow: bool = False  # it may take longer than an answer should


class Requests:
    """Resolves parts and starts jobs, for services and the action."""

    def __init__(self, base: Base, stores: Stores, intake: Intake, jobs: Jobs) -> None:
        self._settings, self._refusals = base.settings, base.refusals
        self._parts, self._intake, self._jobs = stores.parts, intake, jobs
        self._closed = False

    def close(self) -> None:
        """Refuse whatever comes from now on."""
        self._closed = True

    def resolve_part(self, part_id: str, message: Any, accepted: threading.Event | None = None,
                     is_enough: Callable[[KnownPart], bool] = lambda known: False
                     ) -> ResolvedPart:
        """The part of a request, known or on its way; lets go of the message, which may be large.

        `accepted`: a mesh that takes longer than its answer should is begun with only then;
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
        known, content, override = None, b"", (-1.0, -1.0)
        if not carried:
            known = self._parts.known(message.part_id)
        else:
            same = self._parts.find(message.part_id) if message.part_id else None
            if same is None:
                self._intake.check_room(message)
            source = f"request for {part_requests.shown(message.part_id)}"
            try:
                request = part_messages.taken_request(message)
                part_requests.check_request(request, self._settings().max_mesh_bytes)
                override = request.restitution, request.drop_height
                self._settings().scene(override)
            except PoseStatsError as refusal:
                self._refusals.refuse(source, str(refusal))
                raise
            if same is not None and (same.content, same.scene_override) == (
                    request.content, override):
                known = same
        if known is not None:
            content = known.content
            coming = at_hand(known) if is_enough(known) else self._intake.built(known)
            return ResolvedPart(coming, known.part_id, lambda: content, known.scene_override)
        slow = accepted is not None and len(request.triangles) > QUICK_TRIANGLES
        coming = self._intake.take_sent(request, source, accepted if slow else None)
        return ResolvedPart(coming, request.part_id, lambda: request.content, override, slow)

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
        accepted, part = threading.Event(), Future[Part]()

        def pass_on(done: Future[KnownPart]) -> None:
            try:
                part.set_result(wait_for(done).part)
            except BaseException as error:  # belongs to whoever asks for the part
                part.set_exception(error)

        try:
            resolved = self.resolve_part(request.part_id, request.part, accepted)
            if resolved.coming.done() or not resolved.slow:
                try:
                    wait_for(resolved.coming, PATIENCE)
                except futures.TimeoutError:  # up to Python 3.10 not the builtin one
                    if resolved.coming.done():
                        raise
            scene = settings.scene((request.restitution, request.drop_height),
                                   resolved.scene_override)
            resolved.coming.add_done_callback(pass_on)
            return self._jobs.submit(
                JobRequest(resolved.part_id, resolved.content(), scene, drops, request.seed,
                           request.target_error, seconds), part, settings)
        finally:
            accepted.set()


def check_target(value: float) -> None:
    """Refuse a target error that is none; raises RequestError."""
    if not 0.0 <= value < 1.0:
        raise RequestError("a target_error from 0 to below 1, as a fraction", f"{value}",
                           "0.01 is one point; 0 stands for none")


def ending() -> RequestError:
    """The refusal of whatever a node that ends is asked for."""
    return RequestError("a running node", "one that is ending", "start it again")


def wait_for(coming: Future[T], timeout: float | None = None) -> T:
    """What is coming, once it is there; raises PoseStatsError if it is refused."""
    try:
        return coming.result(timeout)
    except CancelledError as error:
        raise ending() from error
