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

"""Pipes, devices and bombs of YAML in the place of plates, and times that are none."""

import os
import time

from builtin_interfaces.msg import Time
from rosgraph_msgs.msg import Clock

from tests.contract.node.harness.client import until
from tests.contract.node.harness.node import NodeProcess

from ..cell import (
    MEGABYTE,
    WEDGE,
    cell_of,
    domain,
    end,
    flat,
    new_id,
    status,
    tried_node,
)
from ..frame import Outcome, Setting, judged

SECONDS = 20.0
"""Longest that a refusal may take; machines differ and are shared."""

REFUSED_TIME = "the node goes on: ValueError: Seconds value must not be negative"
"""What the node logs where rclpy's own callback cannot take a time."""


def pipes_and_bombs_as_plates(setting: Setting) -> Outcome:
    """A node beside a run with a pipe, whose plates are a pipe, a device and bombs of
    YAML.
    """
    run = setting.folder / "bags" / "pose_stats_20260202T024000_000000_42"
    run.mkdir(parents=True)
    os.mkfifo(run / f"{run.name}_1.mcap")
    pipe, bomb, crowd = (
        setting.folder / name for name in ("pipe", "bomb.yaml", "many.yaml")
    )
    os.mkfifo(pipe)
    bomb.write_text(
        "a: &a [x]\n"
        + "".join(
            f"{name}: &{name} [{', '.join(9 * ['*' + previous])}]\n"
            for previous, name in zip("abcdefghi", "bcdefghij", strict=True)
        )
    )
    crowd.write_text("plates:\n" + "".join(f"  p{k}: {{}}\n" for k in range(20_000)))
    with tried_node(setting.folder / "bags") as (node, client):
        client.good("estimate", part=flat(WEDGE, "known"))
        previous = status(node, "VmRSS")
        longest = 0.0
        refused = 0
        files = [pipe, "/dev/zero", bomb, crowd]
        for file in files:
            begin = time.monotonic()
            refused += "plates" in client.set(plates=str(file))
            longest = max(longest, time.monotonic() - begin)
        grown = status(node, "VmHWM") - previous
    return judged(
        len(files),
        f"{refused} refused, within {longest:.1f} s and {grown / MEGABYTE:.0f} MiB",
        all_are_refused=refused == len(files),
        soon=not setting.judges_times or longest < SECONDS,
        without_much_memory=grown < 100 * MEGABYTE,
    )


def a_clock_before_its_time(setting: Setting) -> Outcome:
    """A node with `use_sim_time`, and times on /clock that rclpy cannot hold."""
    with cell_of(domain(), setting.folder, "tried", use_sim_time=True) as (
        node,
        client,
    ):
        clock = client.node.create_publisher(Clock, "/clock", 1)
        until(lambda: clock.get_subscription_count() > 0, "the node")
        number = setting.of(50, 10)
        for second in range(-number, 0):
            clock.publish(Clock(clock=Time(sec=second)))
            client.good("estimate", part=flat(WEDGE, new_id()))

        def stamp():
            clock.publish(Clock(clock=Time(sec=1234)))
            return client.good(
                "estimate", part=flat(WEDGE, new_id())
            ).statistics.header.stamp.sec

        until(lambda: stamp() == 1234, "the clock")
        end(node)
        other_files = [
            line
            for line in node.lines
            if "[ERROR]" in line and REFUSED_TIME not in line
        ]
    return judged(
        number,
        "answered at each, and with the next time that was one",
        nothing_else_failed=not other_files,
    )


def security_without_keys(setting: Setting) -> Outcome:
    """A start with ROS secured, without a keystore and with one that has no keys."""
    keys = setting.folder / "keys"
    (keys / "enclaves" / "pose_stats").mkdir(parents=True)
    lines = []
    statuses = []
    for keystore in ("", str(keys)):
        with NodeProcess(
            setting.folder,
            *("--enclave", "/pose_stats"),
            environment={
                "ROS_SECURITY_ENABLE": "true",
                "ROS_SECURITY_STRATEGY": "Enforce",
                "ROS_SECURITY_KEYSTORE": keystore,
            },
        ) as node:
            statuses.append(node.ended())
            lines.append(node.lines[-2])  # the last one says that this is the end
    return judged(
        len(lines),
        f"status {statuses}: {' / '.join(line[:60] for line in lines)} …",
        refused=statuses == [2, 2],
        told_what_to_do=all("unset ROS_SECURITY_ENABLE" in line for line in lines),
    )
