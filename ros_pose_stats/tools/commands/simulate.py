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

"""`simulate PART`: poses and probabilities of a part by dropping it."""

import argparse

from ...core.records.scene import DEFAULT_DROPS
from .terminal import arguments, running


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "simulate",
        help="drop a part many times and count its poses",
        description="Drop a part many times onto a rigid frictionless plate and count "
        "the poses in which it comes to rest. Ctrl-C stops and reports what has been "
        "done.",
        examples=(
            "ros_pose_stats simulate demo/clamp.stl --unit mm --drops 2e4 --seed 7",
        ),
        run=run,
    )
    arguments.add_part(command, "--accept-open", *arguments.POSE_OPTIONS)
    arguments.add_drop_options(command, DEFAULT_DROPS)
    arguments.add_options(command, *arguments.SCENE_OPTIONS, "--each", "--json")


def run(options: argparse.Namespace) -> int:
    """Simulate and print."""
    part = running.load_part_and_kernels(options)
    from ...core.simulation.simulate import simulate

    return running.run_and_report(part, simulate, options.drops, options)
