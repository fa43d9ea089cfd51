"""Attacks a node in every way that is known here, prints what came of it, and writes the page.

.venv/bin/python -m tests.soak.attacks [--only NAME ...] [--write]
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from benchmarks.report import DOCS, machine

from .attacks import ATTACKS, Outcome
from .cell import own_domain
from .page import reliability_page


def main() -> int:
    """Attack; exit status 1 where a promise was broken."""
    parser = argparse.ArgumentParser(prog="tests.soak.attacks",
                                     description=__doc__.partition("\n")[0])
    parser.add_argument("--only", nargs="+", choices=ATTACKS, metavar="NAME",
                        help="these attacks alone")
    parser.add_argument("--write", action="store_true", help="write docs/reliability.md")
    options = parser.parse_args()
    if options.write and options.only:
        parser.error("--write wants all attacks; leave --only out")
    outcomes: dict[str, Outcome] = {}
    with tempfile.TemporaryDirectory() as folder, own_domain(Path(folder) / "ros") as domain:
        for number, name in enumerate(options.only or ATTACKS):
            try:
                outcomes[name] = ATTACKS[name](domain, Path(folder) / f"bags_{number}")
            except AssertionError as error:
                outcomes[name] = Outcome(1, [str(error)], str(error).partition("\n")[0][:100])
            print(f"{name}: {outcomes[name].measured}", flush=True)
            for broken in outcomes[name].broken:
                print(f"  BROKEN: {broken}", flush=True)
    if options.write:
        page = DOCS / "reliability.md"
        page.write_text(reliability_page(outcomes, machine()), encoding="utf-8")
        print(page)
    return 1 if any(one.broken for one in outcomes.values()) else 0


if __name__ == "__main__":
    raise SystemExit(main())
