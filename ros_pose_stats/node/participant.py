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

"""The DDS participant of a process of ours: it ends with the process, and at once.

Where a participant is taken down, Fast DDS 2.14 now and then waits for ever with the
interpreter locked (its issue 6513), or writes through broken pointers. A participant is
there from the first ROS node of a process to its last. So the first one stays, and the
process is left without tidying up.
"""

import os
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..base.errors import RequestError

KEYSTORE = "ROS_SECURITY_KEYSTORE"
HIDDEN_NAME = "_ros_pose_stats"  # with an underscore, lists of nodes leave it out
MEMORY_LOCK = re.compile(r"/dev/shm/fastrtps_[0-9a-f]{16}_el")

_first_nodes: list[Any] = []  # of each context, never taken away


def join_ros(arguments: Sequence[str] | None, example: str) -> None:
    """Initialise ROS, whose signal handlers stay away, with a node that holds on to it.

    `example`: arguments that rcl can read, for who gave others.
    """
    import rclpy
    from rclpy import signals

    try:
        rclpy.init(
            args=arguments, signal_handler_options=signals.SignalHandlerOptions.NO
        )
        first_node = create_client_node(
            HIDDEN_NAME, use_global_arguments=False, enable_rosout=False
        )
    except Exception as error:
        # What rcl raises for arguments that it cannot parse has no base.
        failure = str(error).strip()
        refuse_without_keys(failure)
        raise RequestError(
            "ROS arguments that rcl can read", failure, example
        ) from error
    _first_nodes.append(first_node)


def create_client_node(name: str, **options: Any) -> Any:
    """A node that nobody asks anything, so that no policy need name its services."""
    import rclpy
    from rclpy import parameter

    return rclpy.create_node(
        name,
        start_parameter_services=False,
        parameter_overrides=[
            parameter.Parameter("start_type_description_service", value=False)
        ],
        **options,
    )


def refuse_without_keys(failure: str) -> None:
    """Refuse to go on where ROS is to be secured and has failed for want of keys."""
    if os.environ.get("ROS_SECURITY_ENABLE") != "true":
        return
    remedy = (
        "make keys and name their enclave, --ros-args --enclave /NAME, as "
        "docs/security.md says, or unset ROS_SECURITY_ENABLE"
    )
    if not os.environ.get(KEYSTORE):
        # rcl goes on without them, unless the strategy is this one.
        if os.environ.get("ROS_SECURITY_STRATEGY") != "Enforce":
            return
        failure = f"no folder of them in {KEYSTORE}"
    elif "security libraries" in failure:
        remedy = (
            "take ROS from its Debian packages, since its wheels have no security, or "
            "unset ROS_SECURITY_ENABLE"
        )
    elif not any(sign in failure for sign in ("SECURITY", "error creating node")):
        return
    raise RequestError(
        "keys for a secured network (ROS_SECURITY_ENABLE=true)", failure, remedy
    )


def finish(status: int) -> int:
    """End the process with this status if it has had a participant, else return it."""
    if not _first_nodes:
        return status
    for stream in (sys.stdout, sys.stderr):
        # Who read it may be gone, and nobody is left to hear of that.
        with suppress(OSError, ValueError):
            stream.flush()
    _remove_shared_memory()
    os._exit(status)


def _remove_shared_memory() -> None:
    """Remove the memory that Fast DDS shares with other processes, half a megabyte.

    It does so itself only where a participant is taken down. Of the process's own one,
    and of no other, the process has a lock file open.
    """
    for descriptor in Path("/proc/self/fd").glob("*"):
        with suppress(FileNotFoundError):  # closed meanwhile, or removed
            lock = descriptor.readlink()
            if MEMORY_LOCK.fullmatch(str(lock)):
                lock.with_name(lock.name.removesuffix("_el")).unlink()
                lock.unlink()
