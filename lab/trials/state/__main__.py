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

"""Command line of the trials of the state."""

from ..frame import program, trial
from . import damage, kills, owners, start

TRIALS = (
    trial(
        kills.kills,
        "a start deleted every file of the folder of meshes, whoever had made it",
    ),
    trial(
        owners.names_alike,
        "two states shared a folder, and a start of one lost a part of the other; "
        "under two names of a file two nodes ran, and 30 of 60 acknowledged parts "
        "were lost",
    ),
    kills.bags_that_go,
    kills.a_disk_that_is_full,
    damage.cut_files,
    damage.flipped_bytes,
    damage.flipped_bytes_read,
    owners.other_versions,
    owners.files_in_use,
    owners.a_disk_to_read_only,
    start.a_start_with_all_parts,
)
SHORT = 0.05

if __name__ == "__main__":
    raise SystemExit(program("state", TRIALS, SHORT))
