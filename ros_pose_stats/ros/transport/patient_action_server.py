"""An action server whose answers reach clients that are still being discovered."""

from __future__ import annotations

from typing import Any

from rclpy.action import ActionServer

from .late_answers import LateAnswers
from .lost_answers import losses


class PatientActionServer(ActionServer):
    """Sends lost answers to goals, to cancels and to requests for results again.

    Parameters
    ----------
    late_answers : LateAnswers
    node : Node
    action_type : type
    action_name : str
    *arguments, **options
        Of rclpy's `ActionServer`.
    """

    def __init__(self, late_answers: LateAnswers, node: Any, action_type: Any, action_name: str,
                 *arguments: Any, **options: Any) -> None:
        self.late_answers = late_answers
        self.action_name = action_name
        super().__init__(node, action_type, action_name, *arguments, **options)

    async def _execute_goal_request(self, request_header_and_message: Any) -> None:
        """Accept or reject a goal as rclpy does, and see whether the client was told.

        The handle of a goal is made of the server's own, so no `_Patient` can stand in here.
        """
        header, request = request_header_and_message
        goal = bytes(request.goal_id.uuid)
        known = goal in self._goal_handles
        with losses() as lost:  # of this thread, in which all of it runs: no callback waits
            await super()._execute_goal_request(request_header_and_message)
        if not lost:
            return
        answer = self._action_type.Impl.SendGoalService.Response()
        accepted = None if known else self._goal_handles.get(goal)
        if accepted is not None:
            answer.accepted, answer.stamp = True, accepted._goal_info.stamp
        self.late_answers.send_later(
            self.action_name, lambda: self._handle.send_goal_response(header, answer))

    async def _execute_cancel_request(self, request_header_and_message: Any) -> None:
        await ActionServer._execute_cancel_request(_Patient(self), request_header_and_message)

    async def _execute_get_result_request(self, request_header_and_message: Any) -> None:
        await ActionServer._execute_get_result_request(_Patient(self), request_header_and_message)


class _Patient:
    """The server, but for a handle that sends lost answers again."""

    def __init__(self, server: PatientActionServer) -> None:
        self._server = server
        self._handle = _PatientHandle(server)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._server, name)

    def _send_result_response(self, request_header: Any, future: Any) -> None:
        ActionServer._send_result_response(self, request_header, future)


class _PatientHandle:
    """The handle of a server, but for the answers to cancels and to requests for results."""

    def __init__(self, server: PatientActionServer) -> None:
        self._server = server

    def __getattr__(self, name: str) -> Any:
        return getattr(self._server._handle, name)

    def send_cancel_response(self, header: Any, answer: Any) -> None:
        self._server.late_answers.send(
            self._server.action_name,
            lambda: self._server._handle.send_cancel_response(header, answer))

    def send_result_response(self, header: Any, answer: Any) -> None:
        self._server.late_answers.send(
            self._server.action_name,
            lambda: self._server._handle.send_result_response(header, answer))
