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

"""Random searches, loads and attacks: `python -m lab.trials` runs all of them in a
short form.

What is set here holds for every process of a trial, before it imports the first
message: DDS within this machine, found quickly, and messages whose fields nobody
checks.
"""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

os.environ |= {
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "ROS_PYTHON_CHECK_FIELDS": "0",
    "FASTRTPS_DEFAULT_PROFILES_FILE": str(
        ROOT / "tests/contract/node/quick_discovery.xml"
    ),
}
