"""The service `~/feeding`: what a feeder is to do with a part, by its present result."""

import math
from dataclasses import replace
from typing import Any

from ros_pose_stats_msgs.msg import PoseStatistics
from ros_pose_stats_msgs.srv import FeedingAnswer

from ...errors import RequestError
from ...records import FlipStatistics, Index
from ...simulation.flips import check_kick, usual_kicks
from ...statistics import counted_flips, feeding, pose_groups
from ...statistics.feeding_plan import FeederCell, plan_feeding
from ..answering_node import Steps
from ..base import Base
from ..jobs import FlipRequest, Jobs, State, run
from ..lanes import done_with, ending
from ..messages import part_messages, part_requests
from ..messages.statistics_messages import fill_bounds, statistics_of_message
from ..parts import known_part, result_store

FLIP_SECONDS = 10.0  # longest that an answer flips for; the fewer flips, the wider its intervals
SEED = 1  # of the flips of an answer: the same question has the same answer
MOST_KICKS = 100
MOST_FLIPPED = 10_000  # parts, scenes and kicks that answers have flipped for


class FeedingService:
    """Answers from flips of its own `jobs`, or of goals if there are enough, or from none."""

    def __init__(self, base: Base, stores: result_store.Stores, jobs: Jobs,
                 reports: run.FlipReports) -> None:
        self._settings = base.settings
        self._parts, self._learnt, _, _ = stores
        self._jobs, self._reports = jobs, reports
        self._flipped: known_part.Memory[run.FlipKey, bool] = known_part.Memory(MOST_FLIPPED)
        base.node.serve(FeedingAnswer, "~/feeding", self.answer)

    def answer(self, request: Any, response: Any) -> Steps:
        """What to do and what a feeder gets, from the result that is latched now."""
        known, settings = self._parts.known(request.part_id), self._settings()
        shown = known.shown
        if shown is None:
            raise RequestError("a part with a result",
                               f"{part_requests.shown(request.part_id)} without one yet",
                               "ask again in a moment")
        latched, scene = shown.latched, shown.scene
        kick = settings.kick(request.kick_height)
        feeding.check_wanted(request.wanted, len(latched.poses))
        feeding.check_rate(request.rate, request.cycle_time)
        cell = counted = None
        if request.plate_length != 0.0 or request.plate_width != 0.0:
            cell = FeederCell(request.rate, (request.plate_length, request.plate_width),
                              request.clearance, request.cycle_time, request.pick_time,
                              request.look_time, request.drop_time)
            cell.check()
        if request.feeder_speed:
            counted = self._learnt.flips(known, latched, request.feeder_speed)
        heights = [kick] if kick else []
        if not kick and (cell is not None or counted is not None):
            heights = list(request.kick_heights) or list(usual_kicks(latched.radius))
        if len(heights) > MOST_KICKS:
            raise RequestError(f"at most {MOST_KICKS} kick_heights", f"{len(heights)}",
                               "ask for fewer")
        seconds = min(FLIP_SECONDS / max(1, len(heights)), settings.max_job_seconds)
        flips: list[FlipStatistics] = []
        job = None
        for height in sorted({check_kick(height) for height in heights}):
            key = run.flip_key(known.digest, scene, height)
            found = self._reports.best.get(key)
            enough = run.flips_in_all(len(latched.poses), 0, settings)
            if found is None or (found.flips < enough and not self._flipped.get(key)):
                job = self._jobs.submit(
                    FlipRequest(known.part_id, known.content, scene, 0, SEED, 0.0, seconds,
                                kick_height=height), done_with(known), settings,
                    is_accepted=job is not None)
                yield job.finished
                found = self._reports.of_jobs.get(job.job_id)
                if job.state is State.CANCELLED:  # nobody but the node itself cancels
                    raise ending()
                if found is None:
                    response.success, response.message = False, job.message
                    return
                self._flipped.put(key, True)
            flips.append(found)
        _answer(request, response, latched, cell, flips, counted)


def _answer(request: Any, response: Any, latched: PoseStatistics, cell: FeederCell | None,
            flips: list[FlipStatistics], counted: Index | None) -> None:
    """Fill in the plan, and what a feeder gets that kicks wrong parts or drops them afresh."""
    found = statistics_of_message(latched)
    dropped = pose_groups.pose_shares(found)
    basis = f"{latched.drops} drops" if latched.drops else "an estimate"
    if latched.observed:
        basis = f"{latched.observed} parts seen"
    basis = f"From {basis} ({latched.method})"
    if flips:
        basis += f" and {sum(kick.flips for kick in flips)} flips"
    if counted is not None:
        poses = tuple(sorted(found.poses, key=lambda pose: pose.index))
        flips = [counted_flips.learn_flips([replace(kick, poses=poses) for kick in flips], counted,
                             request.feeder_speed)]
        basis += f" and {flips[0].observed} seen"
    chosen = flips[0] if flips else None
    if cell is not None:
        plan = plan_feeding(found, request.wanted, cell, flips)
        place = plan.options.index(plan.best)
        chosen = sorted(flips, key=lambda kick: kick.kick_height)[place - 1] if place else None
        response.action = [getattr(response, action.upper()) for action in plan.actions]
        response.parts_on_plate, response.kicks = plan.best.parts, plan.best.kicks
        response.pickable = plan.best.pickable
        fill_bounds(response, parts_per_minute=plan.best.per_minute)
    if chosen is None:
        gain = feeding.drop_afresh(dropped, request.wanted, request.rate)
    else:
        gain = feeding.flip_wrong_ones(dropped, chosen.counts, request.wanted, request.rate,
                                       request.cycle_time)
        response.transition = part_messages.flat(chosen.transition)
        response.kick_height = chosen.kick_height
    fill_bounds(response, accepted=gain.accepted, passes=gain.passes, flips=gain.flips,
                accepted_per_minute=gain.per_minute)
    if math.isnan(dropped.drops):
        basis += (f"; the error of {latched.method} is not known here, so there are no intervals: "
                 f"simulate the part")
    response.message = f"{basis}."
