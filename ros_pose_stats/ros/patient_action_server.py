"""An action server whose answers reach clients that are still being discovered."""

from __future__ import annotations

from typing import Any

from rclpy.action import ActionServer

from .late_answers import LateAnswers, losses


class PatientActionServer(ActionServer):
    """Sends lost answers to goals and to requests for results again.

    Answers to cancels are not: whoever cancels has had an answer from this server before.

    Parameters
    ----------
    late_answers : LateAnswers
    *arguments, **options
        Of rclpy's `ActionServer`.
    """

    def __init__(self, late_answers: LateAnswers, *arguments: Any, **options: Any) -> None:
        self._late_answers = late_answers
        super().__init__(*arguments, **options)

    async def _execute_goal_request(self, request_header_and_message: Any) -> None:
        """Accept or reject a goal as rclpy does, and see whether the client was told."""
        header, request = request_header_and_message
        goal = bytes(request.goal_id.uuid)
        known = goal in self._goal_handles
        with losses() as lost:  # of this thread, in which all of it runs: no callback waits
            await super()._execute_goal_request(request_header_and_message)
        if lost:
            answer = self._action_type.Impl.SendGoalService.Response()
            answer.accepted = goal in self._goal_handles and not known
            answer.stamp = self._node.get_clock().now().to_msg()
            self._late_answers.send_later(
                "simulate_drops", lambda: self._handle.send_goal_response(header, answer))

    def _send_result_response(self, request_header: Any, future: Any) -> None:
        told = super()._send_result_response
        self._late_answers.send("simulate_drops", lambda: told(request_header, future))
