"""Drops a second: `python -m lab.benchmarks.drops [--quick] [--write]`."""

from ..program import benchmark_parser, run_benchmark
from .measure import QUICK, Plan, sections

run_benchmark(
    benchmark_parser("lab.benchmarks.drops", __doc__ or "", "fewer bodies and drops"),
    lambda options: sections(QUICK if options.quick else Plan()),
)
