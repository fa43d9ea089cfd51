"""From what clients ask to parts and jobs."""

import math
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, TimeoutError as NotYet
from typing import Any, NamedTuple, TypeVar

from ...errors import PoseStatsError, RequestError
from ...records import Part
from ..jobs import Job, JobRequest, Jobs
from ..messages import part_messages, part_requests
from ..parts.intake import Intake
from ..parts.known_part import KnownPart, at_hand
from ..parts.part_store import PartStore
from ..refusals import Refusals
from ..settings import Settings

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

    def __init__(self, settings: Callable[[], Settings], parts: PartStore,
                 intake: Intake, jobs: Jobs, refusals: Refusals) -> None:
        self._settings = settings
        self._parts = parts
        self._intake = intake
        self._jobs = jobs
        self._refusals = refusals
        self._closed = False

    def close(self) -> None:
        """Refuse whatever comes from now on."""
        self._closed = True

    def resolve_part(self, part_id: str, message: Any, accepted: threading.Event | None = None,
                     is_enough: Callable[[KnownPart], bool] = lambda known: False
                     ) -> ResolvedPart:
        """The part of a request: known, or carried and on its way.

        `message`: is let go of: the request is kept until it is answered; `accepted`: a mesh that
        takes longer than its answer should is begun with only then; `is_enough`: whether a known
        part will do though it is not built yet. Raises PoseStatsError if there is none, or two.
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
            return self._known_part(self._parts.known(message.part_id), is_enough)
        same = self._parts.find(message.part_id) if message.part_id else None
        if same is None:
            self._intake.check_room(message)
        request, override = self._checked(message)
        if same is not None and (same.content, same.scene_override) == (request.content, override):
            return self._known_part(same, is_enough)
        slow = accepted is not None and len(request.triangles) > QUICK_TRIANGLES
        coming = self._intake.take_sent(request, _source(request.part_id),
                                        accepted if slow else None)
        return ResolvedPart(coming, request.part_id, lambda: request.content, override, slow)

    def _checked(self, message: Any) -> tuple[part_requests.PartRequest, tuple[float, float]]:
        """A carried part and its own scene, as far as that is quickly looked at."""
        try:
            request = part_messages.taken_request(message)
            part_requests.check_request(request, self._settings().max_mesh_bytes)
            override = (request.restitution, request.drop_height)
            self._settings().scene(override)
        except PoseStatsError as refusal:
            self._refusals.refuse(_source(message.part_id), str(refusal))
            raise
        return request, override

    def _known_part(self, known: KnownPart,
                    is_enough: Callable[[KnownPart], bool]) -> ResolvedPart:
        coming = at_hand(known) if is_enough(known) else self._intake.built(known)
        return ResolvedPart(coming, known.part_id, lambda: known.content, known.scene_override)

    def start_job(self, request: Any) -> Job:
        """Accept a drop simulation out of a `StartDropSimulation` or a goal.

        Raises PoseStatsError with the value and the bound.
        """
        settings = self._settings()
        asked = _numbers(request, settings)
        accepted = threading.Event()
        try:
            resolved = self.resolve_part(request.part_id, request.part, accepted)
            if not resolved.slow:
                _refuse_at_once(resolved.coming)
            scene = settings.scene((request.restitution, request.drop_height),
                                   resolved.scene_override)
            return self._jobs.submit(
                JobRequest(resolved.part_id, resolved.content(), scene, *asked),
                _bare_part(resolved.coming), settings)
        finally:
            accepted.set()


def _source(part_id: str) -> str:
    """Where a refused mesh came from, as a terminal can show it."""
    return f"request for {part_requests.shown(part_id)}"


def check_target(value: float) -> None:
    """Refuse a target error that is none; raises RequestError."""
    if not 0.0 <= value < 1.0:
        raise RequestError("a target_error from 0 to below 1, as a fraction", f"{value}",
                           "0.01 is one point; 0 stands for none")


def _numbers(request: Any, settings: Settings) -> tuple[int, int, float, float]:
    """Drops, seed, target error and seconds, within the node's bounds."""
    drops = request.drops or min(settings.drops, settings.max_drops)
    if drops > settings.max_drops:
        raise RequestError(f"at most {settings.max_drops} drops (parameter max_drops)",
                           f"{drops}", "ask for fewer, or raise the parameter")
    check_target(request.target_error)
    seconds = request.max_seconds or settings.max_job_seconds
    if not 0.0 < seconds <= settings.max_job_seconds or math.isnan(seconds):
        raise RequestError(
            f"max_seconds from 0 to {settings.max_job_seconds:g} s (parameter max_job_seconds)",
            f"{request.max_seconds:g} s", "0 stands for the node's")
    return drops, request.seed, request.target_error, seconds


def ending() -> RequestError:
    """The refusal of whatever a node that ends is asked for."""
    return RequestError("a running node", "one that is ending", "start it again")


def wait_for(coming: Future[T], timeout: float | None = None) -> T:
    """What is coming, once it is there; raises PoseStatsError if it is refused."""
    try:
        return coming.result(timeout)
    except CancelledError as error:
        raise ending() from error


def _refuse_at_once(coming: Future[KnownPart]) -> None:
    """Refuse a mesh that is found bad in a moment."""
    try:
        wait_for(coming, PATIENCE)
    except NotYet:
        if coming.done():
            raise


def _bare_part(coming: Future[KnownPart]) -> Future[Part]:
    """The bare part of a known part that may still be coming."""
    part: Future[Part] = Future()

    def pass_on(done: Future[KnownPart]) -> None:
        try:
            part.set_result(wait_for(done).part)
        except BaseException as error:  # belongs to whoever asks for the part
            part.set_exception(error)

    coming.add_done_callback(pass_on)
    return part
