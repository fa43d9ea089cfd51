"""Estimate and drops combined, and the cheapest method for a target error.

.venv/bin/python -m lab.benchmarks.auto [--parts N] [--cases FILE] [--write]
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from lab.frame.results import Section

from ..program import benchmark_parser, run_benchmark
from .cases import Case, drop_parts, read_cases, write_cases
from .choosing import choosing
from .promises import promises

PARTS = 200


def sections(cases: Sequence[Case]) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    yield from promises(cases)
    yield from choosing(cases)


def cases_of(parts: int, file: Path | None, say: Callable[[str], object]) -> list[Case]:
    """Read parts with their drops from a file if it is there; else make them, and write it."""
    if file is not None and file.exists():
        return [one for one in read_cases(file) if one.number < parts]
    made = drop_parts(parts, say)
    if file is not None:
        write_cases(made, file)
    return made


def main() -> None:
    """Read the arguments and measure."""
    parser = benchmark_parser("lab.benchmarks.auto", __doc__ or "")
    parser.add_argument("--parts", type=int, default=PARTS, help="default: %(default)s")
    parser.add_argument("--cases", type=Path, help="keeps the drops for another run")
    run_benchmark(
        parser,
        lambda options: sections(cases_of(options.parts, options.cases, print)),
    )


if __name__ == "__main__":
    main()
