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

"""What a cell asks for its feeder: goals of `~/plan_feeding`."""

from __future__ import annotations

import math
import threading
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from ros_pose_stats_msgs import msg
from ros_pose_stats_msgs.action import PlanFeeding

from ...base.errors import RequestError
from ...core.planning.feeder_cell import FeederCell
from ...core.planning.feeding_plan import FeedingPlan, check_feeding, plan_feeding
from ...core.records import FlipStatistics, Part, PoseStatistics
from ...core.resting.silhouettes import find_lookalikes
from ...core.simulation.flips import check_kick
from ...core.statistics import feeding
from ..answering_node import Steps, advance, answer_request
from ..equipment import Equipment
from ..jobs import FlipRequest, Job, Jobs, State, run
from ..lanes import finished_future, result_or_refusal
from ..memory import Memory
from ..messages import part_messages, part_requests
from ..messages.codes import (
    BusyError,
    NotDoneError,
    refusal_at_end,
)
from ..messages.statistics_messages import (
    fill_bounds,
    note_messages,
    statistics_of_message,
)
from ..parts import intake, part_builder
from ..parts.known_part import KnownPart, LatchedResult
from ..parts.registry import PartRegistry
from .goals import GoalServer

# Longest that an answer flips for; the fewer flips, the wider its intervals.
FLIP_SECONDS = 10.0
SEED = 1  # of the flips of an answer: the same question has the same answer
MAX_KICKS = 100
MAX_FINISHED_KICKS = 10_000  # parts, scenes and kicks that answers have flipped for

T = TypeVar("T")


@dataclass(eq=False)
class Plan:
    """A question of a feeder on its way to an answer."""

    result: Any = field(default_factory=PlanFeeding.Result)
    state: State = State.RUNNING
    message: str = ""  # how it ended, and the code of that
    code: int = msg.Code.OK
    finished: Future[None] = field(default_factory=Future)
    cancelled: Future[None] = field(default_factory=Future)
    job: Job | None = None  # whose flips it waits for
    kick_heights_done: int = 0
    kick_heights_total: int = 0

    @property
    def drops_done(self) -> int:
        """Flips of the job that it waits for."""
        return 0 if self.job is None else self.job.drops_done

    def wait(self, future: Future[T]) -> Steps[T]:
        """Wait for a result, unless the plan is cancelled; raises PoseStatsError."""
        first: Future[None] = Future()

        def end(_: Future[Any]) -> None:
            with suppress(InvalidStateError):  # the other one was first
                first.set_result(None)

        future.add_done_callback(end)
        self.cancelled.add_done_callback(end)
        yield first
        if self.cancelled.done():
            raise NotDoneError("a plan that goes on", self.message, "ask again")
        return result_or_refusal(future)


class PlanFeedingServer(GoalServer[Plan]):
    """Plans from flips of its own jobs, or of goals if they suffice, or from none."""

    def __init__(
        self,
        equipment: Equipment,
        parts: PartRegistry,
        jobs: Jobs,
        reports: run.FlipReports,
        ways_in: intake.Intake,
        outlines: part_builder.Outlines,
    ) -> None:
        self._settings = equipment.settings
        self._intake = ways_in
        self._outlines = outlines
        self._parts = parts
        self._jobs = jobs
        self._reports = reports
        self._finished_kicks: Memory[run.FlipKey, bool] = Memory(MAX_FINISHED_KICKS)
        self._plans: set[Plan] = set()  # that go on
        # of those, and of which waits for which job; a cancel finishes plans at once
        self._plans_lock = threading.RLock()
        jobs.listener.follow = self._follow_flips
        super().__init__(equipment.node, PlanFeeding, "plan_feeding")

    def begin(self, request: Any) -> Plan:
        """Begin a plan; one that is refused has ended."""
        plan = Plan()
        with self._plans_lock:
            self._plans.add(plan)
        advance(self._make(request, plan))
        return plan

    def _make(self, request: Any, plan: Plan) -> Steps[None]:
        """Make a plan, and have its goal told how it ended."""
        yield from answer_request(
            lambda request, result: self._answer(request, result, plan),
            self._node.get_logger().error,
            request,
            plan.result,
        )
        with self._plans_lock:
            self._plans.discard(plan)
        if plan.cancelled.done():
            plan.state = State.CANCELLED
            plan.code = msg.Code.CANCELLED
        else:
            plan.state = State.DONE if plan.result.success else State.FAILED
            plan.code = plan.result.code
            plan.message = plan.result.message
        plan.result.message = ""
        plan.finished.set_result(None)

    def cancel(self, work: Plan, reason: str) -> None:
        """Let a plan go, and its flips where no other plan waits for them."""
        if work.state.ended:
            return
        with self._plans_lock:
            self._plans.discard(work)
            work.message = reason
            with suppress(InvalidStateError):  # it was cancelled before
                work.cancelled.set_result(None)
            job = work.job
            if job is not None and not any(plan.job is job for plan in self._plans):
                self._jobs.cancel(job.job_id, reason)

    def _follow_flips(self, job: Job) -> None:
        """Show the plans that wait for a job how far it is."""
        with self._plans_lock:
            plans = [plan for plan in self._plans if plan.job is job]
        self.follow(*plans)

    def feedback(self, work: Plan) -> Any:
        """How far the flips are."""
        job = work.job
        return PlanFeeding.Feedback(
            kick_heights_done=work.kick_heights_done,
            kick_heights_total=work.kick_heights_total,
            flips_done=0 if job is None else job.drops_done,
            flips_total=0 if job is None else job.flips_total,
        )

    def result(self, work: Plan) -> Any:
        """The plan, as far as there is one."""
        return work.result

    def _answer(self, request: Any, response: Any, plan: Plan) -> Steps[None]:
        """What to do and what a feeder gets, from the result that is latched now."""
        part = self._parts.require(request.part_id)
        settings = self._settings()
        latched = part.latched
        if latched is None:
            raise BusyError(
                "a part with a result",
                f"{part_requests.quote_text(request.part_id)} without one yet",
                "ask again in a moment",
            )
        message = latched.message
        kick = settings.kick(request.kick_height)
        statistics = statistics_of_message(message)
        cell = _feeder_cell(request)
        check_feeding(statistics, request.wanted, cell)
        counted_flips = None
        if request.feeder_setting:
            counted_flips = part.find_flips(message, request.feeder_setting)
        heights = [kick]
        if not kick:
            heights = list(
                cell.kick_heights(
                    message.radius,
                    request.kick_heights or None,
                    counted_flips is not None,
                )
            )
        flips = yield from self._flip(part, latched, heights, plan)
        if not response.success:
            return
        basis = _describe_basis(message, flips)
        if counted_flips is not None:
            poses = tuple(statistics.by_index.values())
            kicks = [replace(kick, poses=poses) for kick in flips]
            flips = [feeding.learn_flips(kicks, counted_flips, request.feeder_setting)]
            basis += f" and {flips[0].counted_flips} seen"
        geometry = yield from plan.wait(self._intake.build_known(part))
        feeding_plan = yield from plan.wait(
            self._outlines.put(
                geometry,
                "a plan",
                _plan_as_seen,
                statistics,
                list(request.wanted),
                cell,
                flips,
                geometry,
            )
        )
        _fill_in_plan(response, feeding_plan, flips)
        if math.isnan(feeding_plan.best.accepted.low):
            basis += (
                f"; the error of {message.method} is not known here, so there are no "
                f"intervals: simulate the part"
            )
        cell_words = feeding_plan.cell
        response.message = " ".join(
            [
                f"{cell_words[:1].upper()}{cell_words[1:]}.",
                f"{feeding_plan.describe_gain()}.",
                f"{basis}.",
            ]
        )
        response.warnings = note_messages(feeding_plan.warnings)

    def _flip(
        self,
        part: KnownPart,
        latched: LatchedResult,
        heights: list[float],
        plan: Plan,
    ) -> Steps[list[FlipStatistics]]:
        """Flips at each height, by height; those of earlier jobs serve if enough.

        A job that fails makes the plan's result a refusal.
        """
        if len(heights) > MAX_KICKS:
            raise RequestError(
                f"at most {MAX_KICKS} kick_heights", f"{len(heights)}", "ask for fewer"
            )
        settings = self._settings()
        flips: list[FlipStatistics] = []
        has_room = False
        radius = latched.message.radius
        kicks = sorted({check_kick(height, radius) for height in heights})
        plan.kick_heights_total = len(kicks)
        for height in kicks:
            key = run.flip_key(part.digest, latched.scene, height)
            flips_at_height = self._reports.counted.get(key)
            flips_needed = run.flips_in_all(len(latched.message.poses), 0, settings)
            if flips_at_height is None or (
                flips_at_height.flips < flips_needed
                and not self._finished_kicks.get(key)
            ):
                request = FlipRequest(
                    part.part_id,
                    part.content,
                    latched.scene,
                    0,
                    SEED,
                    0.0,
                    min(FLIP_SECONDS / len(heights), settings.max_job_seconds),
                    kick_height=height,
                )
                with self._plans_lock:
                    job = plan.job = self._jobs.submit(
                        request, finished_future(part), settings, has_room=has_room
                    )
                has_room = True
                yield from plan.wait(job.finished)
                if job.state is State.CANCELLED:  # no other plan cancels it
                    raise refusal_at_end()
                flips_at_height = job.flips
                if flips_at_height is None:
                    plan.result.success = False
                    plan.result.code = job.code
                    plan.result.message = job.message
                    break
                self._finished_kicks.put(key, True)
            flips.append(flips_at_height)
            plan.kick_heights_done += 1
        return flips


def _feeder_cell(request: Any) -> FeederCell:
    """The cell of a request; without sides it has no plate."""
    sides = request.plate_length, request.plate_width
    return FeederCell(
        request.dropped_per_minute,
        sides if any(sides) else None,
        request.clearance,
        request.cycle_seconds,
        request.pick_seconds,
        request.look_seconds,
        request.drop_seconds,
    )


def _plan_as_seen(
    statistics: PoseStatistics,
    wanted: list[int],
    cell: FeederCell,
    flips: list[FlipStatistics],
    part: Part,
) -> FeedingPlan:
    """A plan with what a camera takes for a wanted pose."""
    return plan_feeding(find_lookalikes(statistics, part), wanted, cell, flips, part)


def _describe_basis(message: msg.PoseStatistics, flips: list[FlipStatistics]) -> str:
    """What an answer is from."""
    basis = f"{message.drops} drops" if message.drops else "an estimate"
    if message.counted_parts:
        basis = f"{message.counted_parts} parts seen"
    basis = f"From {basis} ({message.method})"
    if flips:
        basis += f" and {sum(kick.flips for kick in flips)} flips"
    return basis


def _fill_in_plan(
    response: Any, plan: FeedingPlan, flips: list[FlipStatistics]
) -> None:
    """Fill in what to do with the parts, and what the cell gets."""
    best = plan.best
    response.action = [getattr(response, action.upper()) for action in plan.actions]
    response.parts_on_plate = best.parts
    response.kicks = best.kicks
    response.pickable = best.pickable
    fill_bounds(
        response,
        accepted=best.accepted,
        passes=best.passes,
        flips=best.flips,
        accepted_per_minute=best.per_minute,
        parts_per_minute=best.per_minute,
    )
    if best.is_kicking:
        # The first option is without kicks; the others are by height, as the flips.
        kick = flips[plan.options.index(best) - 1]
        response.transition = part_messages.pack_array(kick.transition)
        response.kick_height = kick.kick_height
