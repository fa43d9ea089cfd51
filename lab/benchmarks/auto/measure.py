"""Estimate and drops combined, and the cheapest method for a target error.

.venv/bin/python -m lab.benchmarks.auto [--parts N] [--cases FILE] [--write]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from ..report import NUMBERS, collect_results, write_page
from ..results import Section, save
from .cases import Case, drop_parts, read_cases, write_cases
from .choosing import choosing
from .promises import promises
from .sharpening import coverage, drops_needed, sharpening

PARTS = 200


def sections(cases: Sequence[Case]) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    yield sharpening(cases)
    yield drops_needed(cases)
    yield coverage(cases)
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


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print, and with `--write` store the results and render the page."""
    parser = argparse.ArgumentParser(
        prog="lab.benchmarks.auto", description=(__doc__ or "").partition("\n")[0]
    )
    parser.add_argument("--parts", type=int, default=PARTS, help="default: %(default)s")
    parser.add_argument("--cases", type=Path, help="keeps the drops for another run")
    parser.add_argument(
        "--write",
        action="store_true",
        help="store numbers/auto.json and render benchmarks.md in docs/measured",
    )
    options = parser.parse_args(arguments)
    results = collect_results(
        sections(cases_of(options.parts, options.cases, print)), print
    )
    if options.write:
        save(results, NUMBERS / "auto.json")
        print(write_page())


if __name__ == "__main__":
    main()
