"""Many inputs of every kind, all judged: `python -m tests.fuzz [--meshes N] [--minutes M]`.

Exit status 1 where anything was wrong.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from collections.abc import Iterator, Sequence

from .large import large_table
from .large_meshes import CASES
from .meshes import KINDS
from .tally import Tally, table
from .watched import Job, Watched, give_way

THOROUGH_EVERY = 8
"""One input of so many is given in other ways too."""


def jobs(kinds: Sequence[str], seed: int) -> Iterator[Job]:
    """Inputs without end, the kinds in turn."""
    for number in itertools.count(seed):
        for kind in kinds:
            yield Job(kind, number, (number - seed) % THOROUGH_EVERY == 0)


def fuzz(kinds: Sequence[str], meshes: int, seed: int, minutes: float) -> Tally:
    """Try inputs until there were enough of them, or for long enough."""
    tally = Tally()
    end = time.monotonic() + 60.0 * minutes
    with Watched() as watched:
        for outcome in watched.outcomes(itertools.islice(jobs(kinds, seed), meshes)):
            tally.add(outcome)
            if tally.tried % 500 == 0:
                print(f"\r{tally.tried} inputs, {len(tally.failed)} failed", end="",
                      file=sys.stderr, flush=True)
            if time.monotonic() > end:
                break
    print(file=sys.stderr)
    return tally


def main(arguments: Sequence[str] | None = None) -> int:
    """Try, print, and return the exit status."""
    parser = argparse.ArgumentParser(prog="tests.fuzz", description=__doc__)
    parser.add_argument("--meshes", type=int, default=20_000, help="inputs at most")
    parser.add_argument("--seed", type=int, default=0, help="of the first input of each kind")
    parser.add_argument("--minutes", type=float, default=10.0, help="at most")
    parser.add_argument("--kind", action="append", choices=sorted(KINDS), help="only this kind")
    parser.add_argument("--large", action="store_true",
                        help=f"time the {len(CASES)} large bad inputs instead")
    options = parser.parse_args(arguments)
    if min(options.meshes, options.minutes) <= 0 or options.seed < 0:
        parser.error("give at least one mesh, a positive time and a seed from 0")
    give_way()
    if options.large:
        text, passed = large_table()
        print(text)
        return 0 if passed else 1
    tally = fuzz(options.kind or list(KINDS), options.meshes, options.seed, options.minutes)
    print(table(tally))
    return 1 if tally.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
