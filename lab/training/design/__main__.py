"""Judges derivatives and suggestions by drops.

.venv/bin/python -m lab.training.design               two parts of each family and the demo parts
.venv/bin/python -m lab.training.design --each 1      one of each family
.venv/bin/python -m lab.training.design --write       writes docs/measured/design.md
.venv/bin/python -m lab.training.design --stored      the page, from what is stored
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from study.output import plain, write_page

from .bodies import all_parts, has_suggestion, make_case
from .gains import Gain, measure_gain
from .page import page
from .slopes import Slope, measure_slopes

DOCS = Path(__file__).resolve().parents[3] / "docs"
STORED = DOCS / "measured" / "numbers" / "design.json"


def measure(each: int, workers: int) -> tuple[list[Slope], list[Gain]]:
    """Measure the parts one after the other."""
    slopes: list[Slope] = []
    gains: list[Gain] = []
    for family, number in all_parts(each):
        case = make_case(family, number)
        print(
            f"{family} {number}: {len(case.space.features)} features",
            file=sys.stderr,
            flush=True,
        )
        slopes += measure_slopes(case, workers)
        if has_suggestion(family, number):
            gains.append(measure_gain(case, workers))
    return slopes, gains


def read_stored() -> tuple[list[Slope], list[Gain]]:
    """What was measured last."""
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    return (
        [Slope(**one) for one in stored["slopes"]],
        [Gain(**one) for one in stored["gains"]],
    )


def main() -> None:
    """Measure, print the page, and write it where that is asked."""
    parser = argparse.ArgumentParser(
        prog="lab.training.design", description=__doc__.partition("\n")[0]
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
    parser.add_argument(
        "--write", action="store_true", help="write what is found to its place"
    )
    parser.add_argument(
        "--stored",
        action="store_true",
        help="measure nothing; take the numbers that are stored",
    )
    options = parser.parse_args()
    slopes, gains = (
        read_stored() if options.stored else measure(options.each, options.workers)
    )
    text = page(slopes, gains)
    print(text)
    if options.write:
        write_page(
            DOCS,
            "design.md",
            text,
            {},
            {"design": {"slopes": plain(slopes), "gains": plain(gains)}},
        )


if __name__ == "__main__":
    main()
