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
