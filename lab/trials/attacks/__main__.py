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

"""Command line of the attacks."""

from ..frame import program, trial
from . import ending, fairness, files, memory, reading

ATTACKS = (
    trial(
        memory.many_large_parts,
        "60 parts in a bound of 64 MB took 870 MB, and it held 430 of them",
    ),
    memory.refused_goals,
    memory.waiting_requests,
    memory.a_flood_of_meshes,
    *fairness.ATTACKS,
    ending.a_disk_that_fills,
    ending.a_flood_of_counts,
    ending.a_signal_during_an_estimate,
    ending.simulated_time_stands_still,
    files.a_clock_before_its_time,
    files.pipes_and_bombs_as_plates,
    trial(files.security_without_keys, "refused with advice about the restitution"),
    trial(
        reading.small_files_that_stand_for_much,
        "STEP of 96 kB took 1.06 GB, of 600 kB all of 12 GB; 100,000 numbers of units "
        "over 30 s",
    ),
    ending.ends_by_sigterm,
)
SHORT = 0.1

if __name__ == "__main__":
    raise SystemExit(program("attacks", ATTACKS, SHORT))
