"""From what clients ask to parts, jobs and answers."""

import functools
import math
from collections.abc import Callable, Generator
from concurrent.futures import Future, wait
from functools import partial
from typing import Any, Protocol

from ...errors import PoseStatsError, RequestError
from ..base import Base
from ..jobs import Job, JobRequest, Jobs
from ..messages import part_messages, part_requests
from ..parts.intake import Intake
from ..parts.known_part import KnownPart, done_with, ending, result_of
from ..parts.result_store import Stores

PATIENCE = 0.004  # seconds that a start waits for a small part, which may be refused
QUICK_TRIANGLES = 1000  # most of such a part

Callback = Callable[..., Any]


class Answering(Protocol):
    """Whoever answers requests."""

    say_failure: Callable[[str], object]


Steps = Generator[Future[Any], Any, None]
"""What a callback waits for in turn; it is given what comes of each."""


def refusing(callback: Callback) -> Callback:
    """Turn refusals into `success = false` and their message, and what waits into a future."""
    @functools.wraps(callback)
    def answer(self: Answering, request: Any, response: Any) -> Any:
        answered: Future[Any] = Future()

        def begin() -> Steps:
            outcome: Steps | None = callback(self, request, response)
            if outcome is not None:
                yield from outcome

        def go_on(steps: Steps, done: Future[Any] | None = None) -> None:
            coming = None
            try:
                try:
                    value = None if done is None else result_of(done)
                except BaseException as error:
                    coming = steps.throw(error)
                else:
                    coming = steps.send(value)
            except StopIteration:
                pass
            except PoseStatsError as refusal:
                response.success, response.message = False, str(refusal)
            except Exception as error:  # the client gets an answer in any case
                response.success = False
                response.message = f"internal failure: {type(error).__name__}: {error}"
                self.say_failure(f"{callback.__name__}: {response.message}")
            if coming is None:
                answered.set_result(response)
            else:  # no thread waits
                coming.add_done_callback(partial(go_on, steps))

        response.success = True
        go_on(begin())
        return response if answered.done() else answered

    return answer


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
