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

"""The node and the bare process beside it: what surrounds them, their start and end."""

import os
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from statistics import median
from typing import NamedTuple

from rclpy.logging import LoggingSeverity, set_logger_level

from lab.frame.results import Row, Section
from tests.contract.node.harness.client import Client
from tests.contract.node.harness.domains import own_domain
from tests.contract.node.harness.node import NodeProcess

from . import bare

TIMED = (
    "From starting the process, its kernels compiled before, to the line that says "
    "`ready`; to the first answer of a service to a client that waits for it, which "
    "includes that the middleware of the two finds each other; and from SIGINT to the "
    "end. `bare`: a process that imports rclpy and the messages and has one service, "
    "in turns with the node. Seconds."
)
OWN = "/pose_stats"


@contextmanager
def surroundings() -> Iterator[tuple[Path, int]]:
    """An empty folder, and a domain that nobody else on this machine uses."""
    with (
        tempfile.TemporaryDirectory(prefix="ros_pose_stats_") as name,
        own_domain() as domain,
    ):
        os.environ |= {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": f"{name}/ros_log",
        }
        # A publisher of meshes does not reach those who read latched ones alone, and
        # two clients have one name.
        for logger in ("planner", "rcl.logging_rosout"):
            set_logger_level(logger, LoggingSeverity.ERROR)
        yield Path(name), domain


def node(log_directory: Path, **values: object) -> NodeProcess:
    """Start the node with bags in a folder of its own."""
    return NodeProcess(log_directory, restore="false", **values)


def bare_process(log_directory: Path) -> NodeProcess:
    """Start the process that does nothing."""
    return NodeProcess(log_directory, program=("-m", bare.__name__))


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


class Life(NamedTuple):
    """Seconds to `ready`, to the first answer, and from SIGINT to the end."""

    ready: float
    answer: float
    end: float


def starting(domain: int, folder: Path, runs: int) -> Section:
    """A row for the node and one for the bare process, with bags in a folder."""
    with node(folder) as warm:
        warm.ready()  # the kernels are compiled now
    calls = {
        "node": (node, OWN, "list_drop_simulations"),
        "bare": (bare_process, bare.PREFIX, bare.SERVICE),
    }
    lives: dict[str, list[Life]] = {name: [] for name in calls}
    for _ in range(runs):
        for name, (begin, prefix, service) in calls.items():
            with Client(domain, prefix) as client:
                lives[name].append(_life(partial(begin, folder), client, service))
    return Section(
        "node_start",
        "Start of the node",
        TIMED,
        tuple(_row(name, of_process) for name, of_process in lives.items()),
    )


def _life(begin: Callable[[], NodeProcess], client: Client, service: str) -> Life:
    started = time.perf_counter()
    with begin() as process:
        process.ready()
        ready = time.perf_counter() - started
        client.service(service)  # waits for an answer
        answer = time.perf_counter() - started
        stopped = time.perf_counter()
        process.stop()
        return Life(ready, answer, time.perf_counter() - stopped)


def _row(name: str, lives: list[Life]) -> Row:
    ready, answer, end = (median(times) for times in zip(*lives, strict=True))
    return Row(
        name,
        {
            "runs": len(lives),
            "ready": ready,
            "least": min(lives).ready,
            "first answer": answer,
            "end": end,
        },
    )
