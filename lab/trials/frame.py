# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""What every program of trials is: trials with their outcomes, printed, judged and put
on a page.

A trial tries something many times and says which promises were broken. The page
`docs/measured/reliability.md` is rendered from what the programs have stored with
`--write`.
"""

import argparse
import tempfile
import time
import traceback
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from lab.frame.machine import describe_machine
from lab.frame.page import DOCS, NUMBERS, Page
from lab.frame.results import Results, Row, Section, save

LONGEST = 2000
"""Characters of a broken promise that are shown of its beginning and of its end."""

TITLES = {
    "fuzz": (
        "Fuzz",
        "Inputs that are not quite right, each made from its seed, handed to the "
        "library and to a node: a sound answer or a refusal in one line, in time. "
        "Bodies are given in other ways too (turned, in other units, renumbered, cut "
        "finer), which must change nothing that rounding does not decide.",
    ),
    "units": (
        "Units",
        "STL files of stairs whose lengths are multiples of a step that people draw "
        "in, 1 mm to 1 m long, read without their unit. At least 99 % of those in "
        "millimetres are to be read right, and each warning is to name the true "
        "length.",
    ),
    "soak": (
        "Soak",
        "Drops of many bodies, and a node that is busy in eleven ways at once while "
        "disks fill, clocks jump and processes die. What clients were told is compared "
        "with the library and looked for in the bags.",
    ),
    "attacks": (
        "Attacks",
        "What careless and hostile neighbours do to the node, in miniature: "
        "each attack meets a node of its own, with meshes of 2 MB where nothing else "
        "is said.",
    ),
    "commands": (
        "Commands",
        "Files and words that are made to trouble a command: it answers or refuses in "
        "one line, within 30 s of the processor and 1.5 GiB.",
    ),
    "state": (
        "State",
        "Kills, full disks and damaged files: what was acknowledged is there after "
        "a start, counts are exact, and bags, which are logs, may go and come.",
    ),
}
PAGE = Page(
    "reliability.md",
    """# Reliability

*This page is written by `python -m lab.trials.fuzz --write`, and so by
`lab.trials.units`, `lab.trials.soak`, `lab.trials.attacks`, `lab.trials.commands` and
`lab.trials.state`, from what each of them stored in `docs/measured/numbers`.
`python -m lab.trials` runs all of them in a short form.
`python -m lab.trials.every_command FILE|FOLDER` runs every command about a part on
files of one's own and prints what reaches standard error.*

Broken is how many promises were not kept. Before is what was seen by hand in November
2026, before it was mended: each case has a trial now, and its figures stand here as
they were noted. The machines were shared, so times give an idea only.
""",
    tuple(TITLES),
)


@dataclass
class Outcome:
    """What came of a trial: how often it was tried, each broken promise, and what was
    seen.
    """

    tried: int = 0
    broken: list[str] = field(default_factory=list)
    seen: str = ""


def judged(tried: int, summary: str, **promises: bool) -> Outcome:
    """An outcome from promises and whether each was kept."""
    return Outcome(
        tried,
        [
            f"{name.replace('_', ' ')}: {summary}"
            for name, good in promises.items()
            if not good
        ],
        summary,
    )


def judges_times(size: float) -> bool:
    """Whether trials of this size judge times: only full runs, which have the machine
    alone.
    """
    return size >= 1.0


class Setting(NamedTuple):
    """How much is tried, as a share of a full run, from which seed on, and in which
    folder.
    """

    size: float
    seed: int
    folder: Path

    @property
    def judges_times(self) -> bool:
        """Whether times are judged."""
        return judges_times(self.size)

    def of(self, full: int, least: int = 1) -> int:
        """So many instead of the number of a full run."""
        return max(least, round(self.size * full))


class Trial(NamedTuple):
    """A name, what is done in a sentence, and the work.

    `before`: what was seen by hand in November 2026, before it was mended.
    """

    name: str
    done: str
    work: Callable[[Setting], Outcome]
    before: str = ""


def trial(work: Callable[[Setting], Outcome], before: str = "") -> Trial:
    """A trial named and described by its function."""
    done = " ".join((work.__doc__ or "").split())
    return Trial(work.__name__.replace("_", " "), done.rstrip("."), work, before)


def program(
    name: str, works: Iterable[Trial | Callable[[Setting], Outcome]], short: float
) -> int:
    """The command line of a program: try, print, perhaps write; 1 where a promise was
    broken.
    """
    trials = [work if isinstance(work, Trial) else trial(work) for work in works]
    title, description = TITLES[name]
    options = _parse(name, [entry.name for entry in trials], short)
    size = short if options.short else options.size
    machine = {
        **describe_machine(),
        "size": f"{size:g}",
        "seed": str(options.seed),
    }
    has_before = any(entry.before for entry in trials)
    rows = [
        _row(entry, size, options.seed, has_before)
        for entry in trials
        if not options.only or entry.name in options.only
    ]
    broken = sum(int(row.cells["broken"]) for row in rows)
    print(f"{name}: {len(rows)} trials, {broken} promises broken", flush=True)
    if options.write:
        section = Section(name, title, description, tuple(rows))
        save(Results(machine, (section,)), DOCS / NUMBERS / f"{name}.json")
        print(PAGE.write())
    return 1 if broken else 0


def _parse(name: str, trials: Sequence[str], short: float) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog=f"lab.trials.{name}", description=TITLES[name][1]
    )
    parser.add_argument(
        "--only", nargs="+", metavar="NAME", help="these trials alone", choices=trials
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
        help=f"store {name}.json and render docs/measured/{PAGE.name}",
    )
    options = parser.parse_args()
    if options.size < 0.0 or options.seed < 0:
        parser.error("give a size and a seed from 0")
    if options.write and options.only:
        parser.error("--write wants all trials; leave --only out")
    return options


def _row(trial: Trial, size: float, seed: int, has_before: bool) -> Row:
    """Try one; whatever it raises is a broken promise."""
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="trial_") as folder:
        try:
            outcome = trial.work(Setting(size, seed, Path(folder)))
        except Exception as error:
            origin = traceback.extract_tb(error.__traceback__)[-1]
            complaint = f"{type(error).__name__} in {origin.name}: {error}"
            outcome = Outcome(1, [complaint], "stopped")
    seconds = time.monotonic() - begin
    print(f"{trial.name} ({seconds:.0f} s): {outcome.tried} tries; {outcome.seen}")
    for line in outcome.broken:
        if len(line) > 2 * LONGEST:
            line = f"{line[:LONGEST]} … {line[-LONGEST:]}"
        print(f"  BROKEN: {line}", flush=True)
    before = {"before": trial.before} if has_before else {}
    return Row(
        trial.name,
        {
            "what is done": trial.done,
            "tries": outcome.tried,
            "broken": len(outcome.broken),
            **before,
            "seen": outcome.seen.replace("|", "/"),
        },
    )
