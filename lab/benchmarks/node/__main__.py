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

"""Latency of the node: `python -m lab.benchmarks.node [--quick] [--write]`."""

import os

os.environ["ROS_PYTHON_CHECK_FIELDS"] = "0"  # read when the first message is imported

from ..program import benchmark_parser, run_benchmark
from .sections import QUICK, Plan, middleware, sections

if __name__ == "__main__":
    run_benchmark(
        benchmark_parser(
            "lab.benchmarks.node", __doc__ or "", "fewer meshes and calls"
        ),
        lambda options: sections(QUICK if options.quick else Plan()),
        middleware=middleware(),
    )
