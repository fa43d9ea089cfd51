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
