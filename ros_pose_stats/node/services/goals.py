"""The actions `~/simulate_drops` and `~/simulate_flips`: goals that are jobs."""

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import suppress
from typing import Any

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
from ..parts import part_builder
from ..parts.intake import Intake
from ..parts.registry import PartRegistry
from .services import Services

FEEDBACK_SECONDS = 0.1
# For the transition that follows a cancel's callback, usually in 1 ms.
CANCEL_SECONDS = 5.0
MAX_PENDING = 1000
RESULT_SECONDS = 900  # results can be asked for this long after the end


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


class GoalServer(ABC):
    """Ties goals to jobs; no thread waits for the end of one."""

    def __init__(self, node: AnsweringNode, kind: Any, name: str, jobs: Jobs) -> None:
        jobs.listener.follow = self._follow
        self._node = node
        self._name = name
        self._kind = kind
        self._jobs = jobs
        # with their jobs, by request, until they have been told how these ended
        self.goals: dict[int, tuple[server.ServerGoalHandle, Job]] = {}
        # requests that are being accepted, with their jobs or the results that refuse
        self._pending: dict[int, tuple[Any, Job | Any]] = {}
        self._lock = threading.Lock()
        self._next_feedback = 0.0
        self._server = Server(
            node,
            kind,
            f"~/{name}",
            execute_callback=lambda goal: None,  # each has its own
            goal_callback=self._accept_request,
            handle_accepted_callback=self._tie_to_job,
            cancel_callback=self._cancel,
            callback_group=ReentrantCallbackGroup(),
            goal_service_qos_profile=SERVICE_QUALITY,
            cancel_service_qos_profile=SERVICE_QUALITY,
            result_service_qos_profile=SERVICE_QUALITY,
            result_timeout=RESULT_SECONDS,
        )

    @abstractmethod
    def start_job(self, request: Any) -> Job:
        """Accept what a goal asks for; PoseStatsError with the value and the bound."""

    @abstractmethod
    def feedback(self, job: Job) -> Any:
        """How far a job is, as a message."""

    @abstractmethod
    def result(self, job: Job) -> Any:
        """What a job has done, as a message without what all results have."""

    def _accept_request(self, request: Any) -> GoalResponse:
        """Queue the job.

        A refused goal is accepted and then aborted: a rejection has no message.
        """
        answer: Job | Any
        try:
            answer = self.start_job(request)
        except Exception as error:  # must not end the executor
            answer = self._kind.Result()
            refuse(answer, error)
            if not isinstance(error, PoseStatsError):
                self._node.get_logger().error(f"{self._name}: {describe_error(error)}")
        with self._lock:
            self._pending[id(request)] = request, answer
            if len(self._pending) > MAX_PENDING:
                # Clients that were gone before the answer never take theirs.
                del self._pending[next(iter(self._pending))]
        return GoalResponse.ACCEPT

    def _tie_to_job(self, goal: server.ServerGoalHandle) -> None:
        """Tie the goal to its job."""
        with self._lock:
            _, answer = self._pending.pop(id(goal.request))
            if isinstance(answer, Job):
                self.goals[id(goal.request)] = goal, answer
        if not isinstance(answer, Job):
            goal.execute(lambda handle: self._refuse(handle, answer))
            return
        if answer.state == State.RUNNING:
            self._show_executing(goal)
        answer.finished.add_done_callback(lambda _: self._complete(goal, answer))

    def _follow(self, job: Job) -> None:
        """Show goals of a job that runs how far it is."""
        time_now = time.monotonic()
        with self._lock:
            goals = [goal for goal, its_job in self.goals.values() if its_job is job]
        for goal in goals:
            self._show_executing(goal)
        if job.drops_done and goals and time_now >= self._next_feedback:
            self._next_feedback = time_now + FEEDBACK_SECONDS
            feedback = self.feedback(job)
            for goal in goals:
                if goal.is_active:
                    goal.publish_feedback(feedback)

    def _cancel(self, goal: server.ServerGoalHandle) -> CancelResponse:
        """Cancel the job once the goal is cancelled, which follows the callback."""
        number = id(goal.request)
        with self._lock:
            # A goal that is accepted just now is still pending.
            _, job = self.goals.get(number) or self._pending.get(number, (None, ""))
        if not isinstance(job, Job) or job.state.ended:
            return CancelResponse.REJECT
        deadline = time.monotonic() + CANCEL_SECONDS

        def cancel() -> None:
            while (
                goal.is_active
                and not goal.is_cancel_requested
                and time.monotonic() < deadline
            ):
                time.sleep(0.001)
            self._jobs.cancel(job.job_id, "cancelled by a client")

        threading.Thread(target=cancel, daemon=True).start()
        return CancelResponse.ACCEPT

    @staticmethod
    def _show_executing(goal: server.ServerGoalHandle) -> None:
        """Tell clients that the job of a goal runs."""
        if goal.status == server.GoalStatus.STATUS_ACCEPTED:
            # rcl raises where it was cancelled, or shown by another thread, just now.
            with suppress(RuntimeError):
                goal.execute()

    def _complete(self, goal: server.ServerGoalHandle, job: Job) -> None:
        """End a goal whose job has ended."""
        self._show_executing(goal)
        self._server.notify_execute(goal, lambda handle: self._end(handle, job))

    def _end(self, goal: server.ServerGoalHandle, job: Job) -> Any:
        result = self.result(job)
        result.success = job.state == State.DONE
        result.code = job.code
        result.message = f"{job.message} {result.message}".strip()
        if result.success:
            goal.succeed()
        elif job.state == State.CANCELLED and goal.is_cancel_requested:
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


class SimulateDropsServer(GoalServer):
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

    def start_job(self, request: Any) -> Job:
        """Accept a drop simulation."""
        try:
            return self._services.start_job(request)
        finally:  # the goal is kept for a while
            request.part = PartMesh(part_id=request.part.part_id)

    def feedback(self, job: Job) -> Any:
        """How far a simulation is."""
        return SimulateDrops.Feedback(
            job_id=job.job_id,
            drops_done=job.drops_done,
            drops_total=job.request.drops,
            expected_error=job.expected_error,
            drops_per_second=job.drops_per_second,
        )

    def result(self, job: Job) -> Any:
        """The statistics of what was done."""
        return SimulateDrops.Result(
            job_id=job.job_id, statistics=self._reports.answer_of(job.job_id, job)
        )


class SimulateFlipsServer(GoalServer):
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

    def start_job(self, request: Any) -> Job:
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
        built_part = self._intake.build_known(part)
        if part.is_built and (
            not part_builder.is_large(part.geometry) or are_found(part.geometry, scene)
        ):
            poses = len(poses_in(part.geometry, scene).poses)
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
            built_part,
            settings,
        )

    def feedback(self, job: Job) -> Any:
        """How far the flips are."""
        return SimulateFlips.Feedback(
            flips_done=job.drops_done, flips_total=job.flips_total
        )

    def result(self, job: Job) -> Any:
        """The transition matrix of what was done."""
        result = SimulateFlips.Result()
        flips = job.flips
        if flips is None:
            return result
        for name in ("part_id", "part_digest", "restitution", "kick_height", "seed"):
            setattr(result, name, getattr(flips, name))
        for warning in flips.warnings:
            if warning.startswith("HEIGHT_SUSPECT"):
                result.message = f"{result.message} {warning}".lstrip()
        result.flips = pack_array(flips.counts.sum(axis=1) + flips.unsettled, "Q")
        result.unsettled = pack_array(flips.unsettled, "Q")
        result.transition = pack_array(flips.transition)
        result.standard_error = pack_array(flips.standard_error)
        return result
