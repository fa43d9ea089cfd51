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

"""Environments by which a process speaks DDS within this machine."""

from pathlib import Path

PROFILES = Path(__file__).parents[1]

SHARED_MEMORY = {
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "FASTRTPS_DEFAULT_PROFILES_FILE": str(PROFILES / "quick_discovery.xml"),
}
"""As a user's: the middleware adds shared memory, whatever else it is told.

A process that is killed leaves that memory behind. Where there is much of it, Fast DDS
complains on the standard output of others, in whatever domain they are.
"""

LOOPBACK = {
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",  # as the file has it
    "FASTRTPS_DEFAULT_PROFILES_FILE": str(PROFILES / "loopback.xml"),
}
"""UDP alone, of which nothing stays and nobody else hears."""
