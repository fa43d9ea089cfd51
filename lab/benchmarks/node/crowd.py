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

"""Round trips of a service beside other clients, each in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from contextlib import ExitStack
from itertools import chain
from random import Random
from typing import Any

from lab.frame.results import Row, Section, Target
from tests.contract.node.harness.client import Client

from .services import OTHERS
from .spread import p99, spread
from .starting import OWN

CLIENTS = 8
CALLS_A_SECOND = 20.0
NEW_SCENE = "estimate, new scene"

TIMED = (
    "{clients} clients, each in a process of its own, call one service {rate:g} times "
    "a second each, at times that are drawn. A time is from when the call was due, so "
    "that one that waits for the one before it counts in full. A known scene has been "
    "asked for before; a new one has a restitution that nobody has asked for, and "
    "the method `split`. The bound is {bound:g} ms, held against the 99th percentile."
)


def requests(part_id: str, random: Random) -> dict[str, tuple[str, dict[str, Any]]]:
    """Service and fields of each call."""
    restitution = random.uniform(0.2, 0.8)
    new_scene = {"part_id": part_id, "method": "split", "restitution": restitution}
    return {
        "get_statistics": ("get_statistics", {"part_id": part_id}),
        "estimate, known scene": ("estimate", {"part_id": part_id}),
        NEW_SCENE: ("estimate", new_scene),
    }


def crowd(part_id: str, seconds: float) -> Section:
    """A row for each call about a known part, which is made for some seconds."""
    rows = []
    with ExitStack() as clients:
        processes = [
            clients.enter_context(_client_process(number, part_id, seconds))
            for number in range(CLIENTS)
        ]
        for name in requests(part_id, Random(0)):
            for process in processes:
                _line(process)  # that it is ready
            for process in processes:
                print(file=process.stdin, flush=True)
            times = [json.loads(_line(process)) for process in processes]
            rows.append(_row(name, list(chain.from_iterable(times))))
    return Section(
        "crowd",
        f"{CLIENTS} clients at {CALLS_A_SECOND:g} Hz",
        TIMED.format(clients=CLIENTS, rate=CALLS_A_SECOND, bound=OTHERS),
        tuple(rows),
    )


def _client_process(number: int, part_id: str, seconds: float) -> subprocess.Popen[str]:
    words = (str(number), part_id, str(seconds))
    return subprocess.Popen(
        [sys.executable, "-m", "lab.benchmarks.node.crowd", *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def _line(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    line = process.stdout.readline()
    if not line:
        raise RuntimeError("a client of the crowd has ended")
    return line


def ask(number: int, part_id: str, seconds: float) -> None:
    """One client: make all calls, each when a line comes on standard input."""
    random = Random(number)
    with Client(int(os.environ["ROS_DOMAIN_ID"]), OWN) as client:
        for name in requests(part_id, random):
            service, fields = requests(part_id, random)[name]
            client.good(service, **fields)
            print("ready", flush=True)
            sys.stdin.readline()
            times = []
            due = time.perf_counter()
            end = due + seconds
            while due < end:
                time.sleep(max(0.0, due - time.perf_counter()))
                service, fields = requests(part_id, random)[name]
                client.good(service, **fields)
                times.append(time.perf_counter() - due)
                due += random.uniform(0.5, 1.5) / CALLS_A_SECOND
            print(json.dumps(times), flush=True)


def _row(name: str, times: list[float]) -> Row:
    targets = () if name == NEW_SCENE else (Target("p99, ms", p99(times), OTHERS),)
    return Row(name, spread(times), targets)


if __name__ == "__main__":
    ask(int(sys.argv[1]), sys.argv[2], float(sys.argv[3]))
