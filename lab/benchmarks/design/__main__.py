"""Judges derivatives by drops.

python -m lab.benchmarks.design               two parts of each family and the demo
parts python -m lab.benchmarks.design --each 1      one of each family python -m
lab.benchmarks.design --write       writes docs/measured/design.md python -m
lab.benchmarks.design --stored      the page, from what is stored
"""

from __future__ import annotations

import argparse
import json
import sys

from lab.frame.documents import plain, write_page
from lab.frame.page import DOCS, NUMBERS

from .cases import all_parts, make_case
from .page import page
from .slopes import Slope, measure_slopes


def measure(count: int, workers: int) -> list[Slope]:
    """Measure the parts one after the other."""
    slopes: list[Slope] = []
    for family, number in all_parts(count):
        case = make_case(family, number)
        features = len(case.space.features)
        print(f"{family} {number}: {features} features", file=sys.stderr, flush=True)
        slopes += measure_slopes(case, workers)
    return slopes


def read_stored() -> list[Slope]:
    """What was measured last."""
    stored = json.loads((DOCS / NUMBERS / "design.json").read_text(encoding="utf-8"))
    return [Slope(**slope) for slope in stored["slopes"]]


def main() -> None:
    """Measure, print the page, and write it with `--write`."""
    parser = argparse.ArgumentParser(
        prog="lab.benchmarks.design", description=__doc__.partition("\n")[0]
    )
    parser.add_argument(
        "--each",
        type=int,
        default=2,
        help="parts of each family (default: %(default)s)",
    )
    parser.add_argument(
        "--workers", type=int, default=2, help="threads (default: %(default)s)"
    )
    parser.add_argument("--write", action="store_true", help="write page and numbers")
    parser.add_argument(
        "--stored",
        action="store_true",
        help="measure nothing; take the numbers that are stored",
    )
    options = parser.parse_args()
    slopes = read_stored() if options.stored else measure(options.each, options.workers)
    text = page(slopes)
    print(text)
    if options.write:
        write_page(DOCS, "design.md", text, {}, {"design": {"slopes": plain(slopes)}})


if __name__ == "__main__":
    main()
