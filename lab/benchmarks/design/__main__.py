"""Judges derivatives by drops: `python -m lab.benchmarks.design [--each N] [--write]`.

`--each`: parts of each family, beside the demo parts.
"""

from ..program import benchmark_parser, run_benchmark
from .sections import PAGE, derivatives


def main() -> None:
    """Read the arguments and measure."""
    parser = benchmark_parser("lab.benchmarks.design", __doc__ or "")
    parser.add_argument(
        "--each",
        type=int,
        default=2,
        help="parts of each family (default: %(default)s)",
    )
    run_benchmark(parser, lambda options: [derivatives(options.each)], PAGE)


if __name__ == "__main__":
    main()
