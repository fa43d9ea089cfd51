"""The cheapest method for a target error.

python -m lab.benchmarks.auto [--parts N] [--write]
"""

from ..program import benchmark_parser, run_benchmark
from .cases import drop_parts
from .choosing import choosing


def main() -> None:
    """Read the arguments and measure."""
    parser = benchmark_parser("lab.benchmarks.auto", __doc__ or "")
    parser.add_argument("--parts", type=int, default=200, help="default: %(default)s")
    run_benchmark(parser, lambda options: choosing(list(drop_parts(options.parts))))


if __name__ == "__main__":
    main()
