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

"""Judges gains by drops: `python -m lab.benchmarks.design [--write]`.

Some half an hour; `--quick`: a minute.
"""

from ..program import benchmark_parser, run_benchmark
from .sections import PAGE, derivatives_section, gains_section

if __name__ == "__main__":
    run_benchmark(
        benchmark_parser(
            "lab.benchmarks.design",
            __doc__ or "",
            quick="three demo parts alone",
        ),
        lambda options: [
            gains_section(options.quick),
            derivatives_section(options.quick),
        ],
        PAGE,
    )
