"""The command line that the benchmarks share."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from .report import write_page
from .results import Results, save

DOCS = Path(__file__).resolve().parents[1] / "docs"


def command(name: str, about: str | None, quick: str, run: Callable[[bool], Results],
            arguments: Sequence[str] | None) -> None:
    """Measure, print, and with `--write` store the results and render the page.

    Parameters
    ----------
    name : str
        Of the benchmark: `core` is `python -m benchmarks.core`, stored in `core.json`.
    about : str or None
        Description for `--help`.
    quick : str
        What `--quick` leaves out.
    run : callable
        Measures, fewer things where it is told True.
    arguments : sequence of str, optional
        Default: the process's own.
    """
    parser = argparse.ArgumentParser(prog=f"benchmarks.{name}", description=about)
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--write", action="store_true",
                        help=f"store docs/benchmarks/{name}.json and render docs/benchmarks.md")
    options = parser.parse_args(arguments)
    if options.quick and options.write:
        parser.error("--write stores full runs; leave --quick out")
    results = run(options.quick)
    if options.write:
        save(results, DOCS / "benchmarks" / f"{name}.json")
        print(write_page(DOCS))
