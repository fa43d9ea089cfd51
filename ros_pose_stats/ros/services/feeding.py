"""The service `~/feeding`: what a feeder gets out of a part's present result."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from ros_pose_stats_msgs.msg import PoseStatistics
from ros_pose_stats_msgs.srv import FeedingAnswer

from ...errors import RequestError
from ...records import DropScene, FlipStatistics
from ...statistics import feeding
from ...statistics.pose_shares import pose_shares
from ..jobs import FlipRequest, Job, Jobs, State
from ..jobs.run import FlipReports, flip_key, flips_in_all
from ..messages import part_messages, part_requests, statistics_messages
from ..parts import known_part, part_store
from ..settings import Settings
from ..transport.answering_node import AnsweringNode
from . import requests, services

FLIP_SECONDS = 10.0
"""Longest that an answer flips for; the fewer flips, the wider its intervals."""

SEED = 1
"""Of the flips of an answer: the same question has the same answer."""


class FeedingService:
    """Answers at once where no flips are needed or they are remembered, else after flipping.

    `jobs`: of this service's flips alone, so that no goal keeps a planner waiting; `goals`: of the
    flips that goals asked for, which serve here too if there are enough.
    """

    def __init__(self, node: AnsweringNode, settings: Callable[[], Settings],
                 parts: part_store.PartStore,
                 jobs: Jobs, reports: FlipReports, goals: FlipReports) -> None:
        self._settings = settings
        self._parts = parts
        self._jobs = jobs
        self._reports = reports
        self._goals = goals
        self.say_failure = node.get_logger().error
        node.serve(FeedingAnswer, "~/feeding", self.answer)

    @services.refusing
    def answer(self, request: Any, response: Any) -> services.Later | None:
        """What a feeder gets, from the result that is latched now."""
        known = self._parts.known(request.part_id)
        with known.numbers.lock:  # both of one result
            latched, scene = known.shown.latched, known.shown.scene
        if latched is None or scene is None:
            raise RequestError("a part with a result",
                               f"{part_requests.shown(request.part_id)} without one yet",
                               "ask again in a moment")
        kick = self._settings().kick(request.kick_height)
        feeding.check_wanted(request.wanted, len(latched.poses))
        feeding.check_rate(request.rate)
        feeding.check_cycle_time(request.cycle_time)
        if kick == 0.0:
            _answer(request, response, latched, None)
            return None
        flips = self._remembered(known, scene, kick, len(latched.poses))
        if flips is not None:
            _answer(request, response, latched, flips)
            return None
        settings = self._settings()
        seconds = min(FLIP_SECONDS, settings.max_job_seconds)
        job = self._jobs.submit(
            FlipRequest(known.part_id, known.content, scene, 0, SEED, 0.0, seconds,
                        kick_height=kick), known_part.at_hand(known.part), settings)
        return services.Later(job.finished, partial(self._go_on, request, response, latched, job))

    def _remembered(self, known: known_part.KnownPart, scene: DropScene, kick: float,
                    poses: int) -> FlipStatistics | None:
        """Flips as many as an answer takes, of goals too, or what there was time for."""
        key = flip_key(known.digest, scene, kick)
        own, of_goals = self._reports.best(key), self._goals.best(key)
        enough = flips_in_all(poses, 0, self._settings()) if own is None else own.flips
        return of_goals if of_goals is not None and of_goals.flips >= enough else own

    def _go_on(self, request: Any, response: Any, latched: PoseStatistics, job: Job) -> None:
        """Answer once the flips are there."""
        flips = self._reports.of_job(job.job_id)
        if job.state is State.CANCELLED:  # nobody but the node itself cancels
            raise requests.ending()
        if flips is None:
            response.success, response.message = False, job.message
            return
        _answer(request, response, latched, flips)


def _answer(request: Any, response: Any, latched: PoseStatistics,
            flips: FlipStatistics | None) -> None:
    """Fill in what a feeder gets that kicks wrong parts; without flips, drops them afresh."""
    dropped = pose_shares(statistics_messages.statistics_of_message(latched))
    basis = f"{latched.drops} drops" if latched.drops else "an estimate"
    if latched.observed:
        basis = f"{latched.observed} parts seen"
    basis = f"From {basis} ({latched.method})"
    if flips is None:
        gain = feeding.drop_afresh(dropped, request.wanted, request.rate)
    else:
        gain = feeding.flip_wrong_ones(dropped, flips.counts, request.wanted, request.rate,
                                request.cycle_time)
        response.transition = part_messages.flat(flips.transition)
        basis += f" and {flips.flips} flips"
    fill_response(response, gain)
    if math.isnan(dropped.drops):
        basis += (f"; the error of {latched.method} is not known here, so there are no intervals: "
                 f"drop the part")
    response.message = f"{basis}."


def fill_response(response: Any, gain: feeding.Feeding) -> None:
    """Put the numbers and their bounds into a response."""
    for name, number in (("accepted", gain.accepted), ("passes", gain.passes),
                         ("flips", gain.flips), ("accepted_per_minute", gain.per_minute)):
        value, low, high = number
        setattr(response, name, value)
        setattr(response, f"{name}_low", low)
        setattr(response, f"{name}_high", high)
