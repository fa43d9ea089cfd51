"""Judges derivatives by drops: `python -m lab.benchmarks.design [--write]`."""

from ..program import benchmark_parser, run_benchmark
from .sections import PAGE, derivatives

if __name__ == "__main__":
    run_benchmark(
        benchmark_parser("lab.benchmarks.design", __doc__ or ""),
        lambda _: [derivatives()],
        PAGE,
    )
