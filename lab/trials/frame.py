"""What every program of trials is: trials with their outcomes, printed, judged and put on a page.

A trial tries something many times and says which promises were broken. The page
`docs/measured/reliability.md` is rendered from what the programs have stored with `--write`.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from lab.benchmarks.report import machine

from . import ROOT

STORED = ROOT / "docs" / "measured" / "numbers"
PAGE = ROOT / "docs" / "measured" / "reliability.md"
LONGEST = 2000
"""Characters of a broken promise that are shown of its beginning and of its end."""

TITLES = {
    "fuzz": (
        "Fuzz",
        "Inputs that are not quite right, each made from its seed, handed to the "
        "library and to a node: a sound answer or a refusal in one line, in time. Bodies are "
        "given in other ways too (turned, in other units, renumbered, cut finer), which must "
        "change nothing that rounding does not decide.",
    ),
    "soak": (
        "Soak",
        "Drops of many bodies, and a node that is busy in eleven ways at once while "
        "disks fill, clocks jump and processes die. What clients were told is compared with "
        "the library and looked for in the bags.",
    ),
    "attacks": (
        "Attacks",
        "What careless and hostile neighbours do to the node, in miniature: "
        "each attack meets a node of its own, with meshes of 2 MB where nothing else is "
        "said.",
    ),
    "state": (
        "State",
        "Kills, full disks and damaged files: what was acknowledged is there after "
        "a start, counts are exact, and bags, which are logs, may go and come.",
    ),
}
INTRODUCTION = """# Reliability

*This page is written by `python -m lab.trials.fuzz --write`, and so by `lab.trials.soak`,
`lab.trials.attacks` and `lab.trials.state`, from what each of them stored in
`docs/measured/numbers`. `python -m lab.trials` runs all of them in a short form.*

Broken is how many promises were not kept. The machines were shared, so times give an idea only.
"""


@dataclass
class Outcome:
    """What came of a trial: how often it was tried, each broken promise, and what was seen."""

    tried: int = 0
    broken: list[str] = field(default_factory=list)
    seen: str = ""


def judged(tried: int, seen: str, **kept: bool) -> Outcome:
    """An outcome from promises and whether each was kept."""
    return Outcome(
        tried,
        [
            f"{name.replace('_', ' ')}: {seen}"
            for name, good in kept.items()
            if not good
        ],
        seen,
    )


class Setting(NamedTuple):
    """How much is tried, as a share of a full run, from which seed on, and in which folder."""

    size: float
    seed: int
    folder: Path

    @property
    def judges_times(self) -> bool:
        """Whether times are judged: in a full run, on a machine that does nothing else."""
        return self.size >= 1.0

    def of(self, full: int, least: int = 1) -> int:
        """So many instead of the number of a full run."""
        return max(least, round(self.size * full))


class Trial(NamedTuple):
    """A name, what is done in a sentence, and the work."""

    name: str
    done: str
    work: Callable[[Setting], Outcome]


def trial(work: Callable[[Setting], Outcome]) -> Trial:
    """A trial named and described by its function."""
    return Trial(
        work.__name__.replace("_", " "), (work.__doc__ or "").rstrip("."), work
    )


def program(name: str, trials: Sequence[Trial], short: float) -> int:
    """The command line of a program: try, print, perhaps write; 1 where a promise was broken."""
    parser = argparse.ArgumentParser(
        prog=f"lab.trials.{name}", description=TITLES[name][1]
    )
    parser.add_argument(
        "--only",
        nargs="+",
        metavar="NAME",
        help="these trials alone",
        choices=[one.name for one in trials],
    )
    parser.add_argument(
        "--short", action="store_true", help=f"the same as --size {short:g}"
    )
    parser.add_argument(
        "--size", type=float, default=1.0, help="share of the full numbers"
    )
    parser.add_argument("--seed", type=int, default=1, help="from which seed on")
    parser.add_argument(
        "--write",
        action="store_true",
        help=f"store {name}.json and render docs/measured/reliability.md",
    )
    options = parser.parse_args()
    if options.size < 0.0 or options.seed < 0:
        parser.error("give a size and a seed from 0")
    if options.write and options.only:
        parser.error("--write wants all trials; leave --only out")
    size = short if options.short else options.size
    where = machine()
    begin = time.monotonic()
    rows = [
        _row(one, size, options.seed)
        for one in trials
        if not options.only or one.name in options.only
    ]
    broken = sum(row["broken"] for row in rows)
    print(
        f"{name}: {len(rows)} trials, {sum(row['tried'] for row in rows)} tries, {broken} "
        f"broken, {time.monotonic() - begin:.0f} s",
        flush=True,
    )
    if options.write:
        stored = {
            "machine": {**where, "size": f"{size:g}", "seed": str(options.seed)},
            "rows": rows,
        }
        (STORED / f"{name}.json").write_text(
            json.dumps(stored, indent=1) + "\n", "utf-8"
        )
        PAGE.write_text(page(), "utf-8")
        print(PAGE)
    return 1 if broken else 0


def _row(one: Trial, size: float, seed: int) -> dict[str, Any]:
    """Try one; whatever it raises is a broken promise."""
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="trial_") as folder:
        try:
            found = one.work(Setting(size, seed, Path(folder)))
        except Exception as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            found = Outcome(
                1, [f"{type(error).__name__} in {place.name}: {error}"], "stopped"
            )
    print(
        f"{one.name} ({time.monotonic() - begin:.0f} s): {found.tried} tries; {found.seen}"
    )
    for line in found.broken:
        short = len(line) <= 2 * LONGEST
        print(f"  BROKEN: {line if short else f'{line[:LONGEST]} … {line[-LONGEST:]}'}")
    print(end="", flush=True)
    return {
        "name": one.name,
        "done": one.done,
        "tried": found.tried,
        "broken": len(found.broken),
        "seen": found.seen,
    }


def page() -> str:
    """The page of everything that is stored."""
    parts = [INTRODUCTION]
    for name, (title, about) in TITLES.items():
        file = STORED / f"{name}.json"
        if file.exists():
            stored = json.loads(file.read_text("utf-8"))
            lines = [
                f"## {title}\n\n{about}\n",
                "| trial | what is done | tries | broken | seen |",
                "|---|---|---:|---:|---|",
            ]
            lines += [
                f"| {row['name']} | {row['done']} | {row['tried']} | {row['broken']} | "
                f"{row['seen'].replace('|', '/')} |"
                for row in stored["rows"]
            ]
            where = ", ".join(
                f"{key} {value}" for key, value in stored["machine"].items()
            )
            parts.append("\n".join([*lines, f"\n{where}.\n"]))
    return "\n".join(parts)
