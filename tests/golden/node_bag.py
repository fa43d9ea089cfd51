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

"""What the bag of a node holds that was sent the demo parts; of one checkout beside
another.
"""

import json
import os
import subprocess
import sys

from tests.contract.node.harness.node import NodeProcess
from tests.contract.node.harness.transports import LOOPBACK
from tests.golden.answers import without_times

DEMO = ("clamp", "bracket", "prism", "cylinder")


def analysis_of_bag(folder, checkout):
    """What the command `bag` says of the parts of such a bag, less times.

    The parts are those that `write_parts` wrote below the folder.
    """
    runs = folder / "runs"
    command = [sys.executable, "-m", "ros_pose_stats"]
    environment = {
        **os.environ,
        "PYTHONPATH": str(checkout),
        "PYTHONWARNINGS": "ignore",
        "ROS_DOMAIN_ID": str(os.getpid() % 100 + 1),
        **LOOPBACK,
    }
    with NodeProcess(runs, environment=environment, folder=checkout) as node:
        node.ready()
        for name in DEMO:
            subprocess.run(
                [
                    *command,
                    "publish",
                    folder / "parts" / f"{name}.stl",
                    "--unit",
                    "mm",
                    "--seconds",
                    "60",
                ],
                env=environment,
                cwd=checkout,
                check=True,
                capture_output=True,
            )
    outcome = subprocess.run(
        [*command, "bag", *runs.iterdir(), "--json"],
        check=True,
        cwd=checkout,
        env=environment,
        capture_output=True,
        text=True,
    ).stdout
    return {
        f"bag: {part['part_id']}": without_times(part)
        for part in json.loads(outcome)["parts"]
    }
