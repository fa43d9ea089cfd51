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

"""Goals of actions, and those that are jobs: `simulate_drops`, `simulate_flips`."""

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from rclpy.action import ActionServer, CancelResponse, GoalResponse, server
from rclpy.callback_groups import ReentrantCallbackGroup
from ros_pose_stats_msgs.action import SimulateDrops, SimulateFlips
from ros_pose_stats_msgs.msg import PartMesh

from ...base.errors import PoseStatsError, RequestError
from ...core.resting.poses import are_found, poses_in
from ..answering_node import SERVICE_QUALITY, AnsweringNode
from ..equipment import Equipment
from ..jobs import FlipRequest, Job, Jobs, State, job_reports, run
from ..messages.codes import describe_error, refuse
from ..messages.part_messages import pack_array
from ..messages.statistics_messages import note_messages
from ..parts import part_builder
from ..parts.intake import Intake
from ..parts.registry import PartRegistry
from .services import Services

FEEDBACK_SECONDS = 0.1
# For the transition that follows a cancel's callback, usually in 1 ms.
CANCEL_SECONDS = 5.0
MAX_PENDING = 1000
# Results can be asked for this long after the end, and take memory as long, as do the
# meshes of their requests.
RESULT_SECONDS = 60


class Work(Protocol):
    """What a goal is tied to: a job, or whatever else has an end."""

    state: State
    message: str  # how it ended, and the code of that
    code: int
    finished: Future[None]  # done once its end can be seen

    @property
    def drops_done(self) -> int:
        """Drops or flips so far; feedback begins with the first."""


W = TypeVar("W", bound=Work)


class Refusal(NamedTuple):
    """The result of a goal that was refused."""

    result: Any


class Server(ActionServer):
    """Shows a goal as executing without a thread that waits for its end."""

    def notify_execute(
        self,
        goal_handle: server.ServerGoalHandle,
        execute_callback: Callable[[server.ServerGoalHandle], Any] | None,
    ) -> None:
        """Have what ends a goal called; `execute` alone names nothing."""
        if execute_callback is not None:
            super().notify_execute(goal_handle, execute_callback)


class GoalServer(ABC, Generic[W]):
    """Ties goals to work; no thread waits for the end of it."""

    def __init__(self, node: AnsweringNode, kind: Any, name: str) -> None:
        self._node = node
        self._name = name
        self._kind = kind
        # with their work, by request, until they have been told how it ended
        self.goals: dict[int, tuple[server.ServerGoalHandle, W]] = {}
        # requests that are being accepted, with their work or the results that refuse
        self._pending: dict[int, tuple[Any, W | Refusal]] = {}
        self._lock = threading.Lock()
        self._next_feedback = 0.0
        self._server = Server(
            node,
            kind,
            f"~/{name}",
            execute_callback=lambda goal: None,  # each has its own
            goal_callback=self._accept_request,
            handle_accepted_callback=self._tie_to_work,
            cancel_callback=self._cancel,
            callback_group=ReentrantCallbackGroup(),
            goal_service_qos_profile=SERVICE_QUALITY,
            cancel_service_qos_profile=SERVICE_QUALITY,
            result_service_qos_profile=SERVICE_QUALITY,
            result_timeout=RESULT_SECONDS,
        )

    @abstractmethod
    def begin(self, request: Any) -> W:
        """Accept what a goal asks for; PoseStatsError with the value and the bound."""

    @abstractmethod
    def cancel(self, work: W, reason: str) -> None:
        """Have work end soon."""

    @abstractmethod
    def feedback(self, work: W) -> Any:
        """How far work is, as a message."""

    @abstractmethod
    def result(self, work: W) -> Any:
        """What was done, as a message without what all results have."""

    def _accept_request(self, request: Any) -> GoalResponse:
        """Begin the work.

        A refused goal is accepted and then aborted: a rejection has no message.
        """
        answer: W | Refusal
        try:
            answer = self.begin(request)
        except Exception as error:  # must not end the executor
            answer = Refusal(self._kind.Result())
            refuse(answer.result, error)
            if not isinstance(error, PoseStatsError):
                self._node.get_logger().error(f"{self._name}: {describe_error(error)}")
        with self._lock:
            self._pending[id(request)] = request, answer
            if len(self._pending) > MAX_PENDING:
                # Clients that were gone before the answer never take theirs.
                del self._pending[next(iter(self._pending))]
        return GoalResponse.ACCEPT

    def _tie_to_work(self, goal: server.ServerGoalHandle) -> None:
        """Tie the goal to its work."""
        with self._lock:
            _, answer = self._pending.pop(id(goal.request))
            if not isinstance(answer, Refusal):
                self.goals[id(goal.request)] = goal, answer
        if isinstance(answer, Refusal):
            goal.execute(lambda handle: self._refuse(handle, answer.result))
            return
        if answer.state == State.RUNNING:
            self._show_executing(goal)
        answer.finished.add_done_callback(lambda _: self._complete(goal, answer))

    def follow(self, *works: W) -> None:
        """Show goals of work that goes on how far it is, all of them as often."""
        time_now = time.monotonic()
        with self._lock:
            pairs = [
                (goal, work) for goal, work in self.goals.values() if work in works
            ]
        for goal, _ in pairs:
            self._show_executing(goal)
        begun = [(goal, work) for goal, work in pairs if work.drops_done]
        if begun and time_now >= self._next_feedback:
            self._next_feedback = time_now + FEEDBACK_SECONDS
            for goal, work in begun:
                if goal.is_active:
                    goal.publish_feedback(self.feedback(work))

    def _cancel(self, goal: server.ServerGoalHandle) -> CancelResponse:
        """Cancel the work once the goal is cancelled, which follows the callback."""
        number = id(goal.request)
        with self._lock:
            # A goal that is accepted just now is still pending.
            pair = self.goals.get(number) or self._pending.get(number)
        work = None if pair is None else pair[1]
        if work is None or isinstance(work, Refusal) or work.state.ended:
            return CancelResponse.REJECT
        deadline = time.monotonic() + CANCEL_SECONDS

        def cancel() -> None:
            while (
                goal.is_active
                and not goal.is_cancel_requested
                and time.monotonic() < deadline
            ):
                time.sleep(0.001)
            self.cancel(work, "cancelled by a client")

        threading.Thread(target=cancel, daemon=True).start()
        return CancelResponse.ACCEPT

    @staticmethod
    def _show_executing(goal: server.ServerGoalHandle) -> None:
        """Tell clients that the work of a goal goes on."""
        if goal.status == server.GoalStatus.STATUS_ACCEPTED:
            # rcl raises where it was cancelled, or shown by another thread, just now.
            with suppress(RuntimeError):
                goal.execute()

    def _complete(self, goal: server.ServerGoalHandle, work: W) -> None:
        """End a goal whose work has ended."""
        self._show_executing(goal)
        self._server.notify_execute(goal, lambda handle: self._end(handle, work))

    def _end(self, goal: server.ServerGoalHandle, work: W) -> Any:
        result = self.result(work)
        result.success = work.state == State.DONE
        result.code = work.code
        result.message = work.message
        if result.success:
            goal.succeed()
        elif work.state == State.CANCELLED and goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        with self._lock:
            del self.goals[id(goal.request)]
        self._node.last_answer = time.monotonic()  # the result is on its way
        return result

    @staticmethod
    def _refuse(goal: server.ServerGoalHandle, refusal: Any) -> Any:
        goal.abort()
        return refusal


class JobServer(GoalServer[Job]):
    """Goals that are jobs of a queue."""

    def __init__(self, node: AnsweringNode, kind: Any, name: str, jobs: Jobs) -> None:
        jobs.listener.follow = self.follow
        self._jobs = jobs
        super().__init__(node, kind, name)

    def cancel(self, work: Job, reason: str) -> None:
        """Cancel a job for everybody."""
        self._jobs.cancel(work.job_id, reason)


class SimulateDropsServer(JobServer):
    """Goals that are drop simulations."""

    def __init__(
        self,
        equipment: Equipment,
        services: Services,
        jobs: Jobs,
        reports: job_reports.JobReports,
    ) -> None:
        self._services = services
        self._reports = reports
        super().__init__(equipment.node, SimulateDrops, "simulate_drops", jobs)

    def begin(self, request: Any) -> Job:
        """Accept a drop simulation."""
        try:
            return self._services.start_job(request)
        finally:  # the goal is kept for a while
            request.part = PartMesh(part_id=request.part.part_id)

    def feedback(self, work: Job) -> Any:
        """How far a simulation is."""
        return SimulateDrops.Feedback(
            job_id=work.job_id,
            drops_done=work.drops_done,
            drops_total=work.request.drops,
            expected_error=work.expected_error,
            drops_per_second=work.drops_per_second,
        )

    def result(self, work: Job) -> Any:
        """The statistics of what was done."""
        return SimulateDrops.Result(
            job_id=work.job_id, statistics=self._reports.answer_of(work.job_id, work)
        )


class SimulateFlipsServer(JobServer):
    """Goals that are flips."""

    def __init__(
        self,
        equipment: Equipment,
        parts: PartRegistry,
        intake: Intake,
        jobs: Jobs,
    ) -> None:
        self._settings = equipment.settings
        self._parts = parts
        self._intake = intake
        super().__init__(equipment.node, SimulateFlips, "simulate_flips", jobs)

    def begin(self, request: Any) -> Job:
        """Accept flips; too many are refused at once where the poses are at hand."""
        settings = self._settings()
        part = self._parts.require(request.part_id)
        kick = settings.kick(request.kick_height)
        if request.kick_height < 0.0 and not kick:
            raise RequestError(
                "a kick_height of 0 m or more, for the parameter flip_height is 0",
                f"{request.kick_height:g}",
                "half the part's radius flips most parts",
            )
        scene = settings.scene(part.scene_override)
        future_part = self._intake.build_for_job(part)
        geometry = part.source.part
        if geometry is not None and (
            not part_builder.is_large(geometry) or are_found(geometry, scene)
        ):
            poses = len(poses_in(geometry, scene).poses)
            run.flips_in_all(poses, request.drops, settings)
        return self._jobs.submit(
            FlipRequest(
                part.part_id,
                part.content,
                scene,
                request.drops,
                request.seed,
                0.0,
                settings.max_job_seconds,
                kick_height=kick,
            ),
            future_part,
            settings,
        )

    def feedback(self, work: Job) -> Any:
        """How far the flips are."""
        return SimulateFlips.Feedback(
            flips_done=work.drops_done, flips_total=work.flips_total
        )

    def result(self, work: Job) -> Any:
        """The transition matrix of what was done."""
        result = SimulateFlips.Result()
        flips = work.flips
        if flips is None:
            return result
        for name in ("part_id", "part_digest", "restitution", "kick_height", "seed"):
            setattr(result, name, getattr(flips, name))
        result.warnings = note_messages(flips.warnings)
        result.flips = pack_array(flips.counts.sum(axis=1) + flips.unsettled, "Q")
        result.unsettled = pack_array(flips.unsettled, "Q")
        result.transition = pack_array(flips.transition)
        result.standard_error = pack_array(flips.standard_error)
        return result
