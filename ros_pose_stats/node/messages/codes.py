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

"""Which code of `Code.msg` a client gets with what was refused or has failed."""

from typing import Any

from ros_pose_stats_msgs.msg import Code

from ...base import errors


class UnknownPartError(errors.RequestError):
    """A part that the node does not know."""


class NotFoundError(errors.RequestError):
    """Something else that is not there: a job, or what nobody has counted."""


class BusyError(errors.RequestError):
    """Nothing is wrong with the request, but now it cannot be done."""


class NotDoneError(BusyError):
    """What was asked for was begun, and not done for a reason that is not its own."""


CODES: dict[type[BaseException], int] = {
    UnknownPartError: Code.UNKNOWN_PART,
    NotFoundError: Code.NOT_FOUND,
    BusyError: Code.BUSY,
    errors.TimedOutError: Code.TIMED_OUT,
    errors.MeshError: Code.BAD_MESH,
    errors.MeshFileError: Code.BAD_MESH,
    errors.MassPropertiesError: Code.BAD_VALUE,
    errors.RequestError: Code.BAD_VALUE,
}
"""A class stands for those that are derived from it, but for what they have here."""


def code_of(error: BaseException) -> int:
    """The code of an error; INTERNAL for what is no refusal."""
    codes = (CODES[kind] for kind in type(error).__mro__ if kind in CODES)
    return next(codes, Code.INTERNAL)


def describe_error(error: BaseException) -> str:
    """What a client is told: a refusal as it is, all else as an internal failure."""
    if isinstance(error, errors.PoseStatsError):
        return str(error)
    return f"internal failure: {type(error).__name__}: {error}"


def refuse(answer: Any, error: BaseException) -> None:
    """Say in a response or a result that there is none, and why."""
    answer.success = False
    answer.code = code_of(error)
    answer.message = describe_error(error)


def refusal_at_end() -> NotDoneError:
    """The refusal of whatever a node that ends is asked for."""
    return NotDoneError("a running node", "one that is ending", "start it again")
