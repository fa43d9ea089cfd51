"""Ten small mistakes in ten rooms, one at a time in a copy: which test sees each of them.

    python -m lab.trials.mutations [--only ROOM ...]

The tests are quick ones, as `make test` runs them; those named for a mutation are where somebody
would look for it. Exit status 1 where fewer than nine in ten are caught.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Final, NamedTuple

from . import ROOT

LEAST: Final = 0.9
"""Share of the mutations that is to be caught."""

PATIENCE: Final = "60"
"""Seconds for which tests of nodes wait for what a mistake may have made impossible."""

COPIED: Final = ("ros_pose_stats", "tests", "study", "lab")
"""Folders that the tests import from."""

FAILED: Final = re.compile(r"^(?:FAILED|ERROR) (tests/(\w+)/\S+)", re.MULTILINE)


class Mutation(NamedTuple):
    """A text in a file of a room, what is put in its place, and the tests of what it does."""

    room: str
    mistake: str
    file: str
    text: str
    instead: str
    tests: tuple[str, ...]

    @property
    def environment(self) -> dict[str, str]:
        """Python runs mutated kernels itself: to compile them all would take minutes."""
        return {"NUMBA_DISABLE_JIT": "1"} if "/kernels/" in self.file else {}


MUTATIONS: Final = (
    Mutation(
        "kernels/drops",
        "a sign: an impact gives back less the more elastic it is",
        "ros_pose_stats/core/kernels/drops/impacts.py",
        "impulse = -(1.0 + restitution) * speed",
        "impulse = -(1.0 - restitution) * speed",
        ("tests/truth/kernels/test_contacts.py",),
    ),
    Mutation(
        "kernels/body",
        "a quaternion's order: w first",
        "ros_pose_stats/core/kernels/body/standing.py",
        "x, y, z, w = quaternions[i]",
        "w, x, y, z = quaternions[i]",
        ("tests/truth/poses/test_pose_geometry.py::TestEveryPose",),
    ),
    Mutation(
        "mesh",
        "off by one: what lies in the first shell lies in none",
        "ros_pose_stats/core/mesh/shells.py",
        "in_metal = around >= 0 and outward[around]",
        "in_metal = around > 0 and outward[around]",
        ("tests/truth/mesh/test_shells.py",),
    ),
    Mutation(
        "resting",
        "a swapped comparison: the high members of a pose count as the low ones",
        "ros_pose_stats/core/resting/equilibria.py",
        "near = found.heights < (1.0 + tolerance)",
        "near = found.heights > (1.0 + tolerance)",
        ("tests/truth/poses/test_persistence.py",),
    ),
    Mutation(
        "statistics",
        "a lost half: both tails of an interval are as wide as one",
        "ros_pose_stats/core/statistics/errors.py",
        "(1.0 - level) / 2.0",
        "(1.0 - level)",
        ("tests/contract/library/test_simulate_answers.py",),
    ),
    Mutation(
        "estimators",
        "a product in place of a ratio: far faces count more",
        "ros_pose_stats/core/estimators/published.py",
        "arrays.angle[found.faces] / arrays.distance[found.faces]",
        "arrays.angle[found.faces] * arrays.distance[found.faces]",
        ("tests/truth/estimates/test_closed_forms.py",),
    ),
    Mutation(
        "simulation",
        "off by one: a drop is left out between two chunks",
        "ros_pose_stats/core/simulation/chunks.py",
        "return self._next - count, count",
        "return self._next - count + 1, count",
        ("tests/contract/library/test_simulate_runs.py",),
    ),
    Mutation(
        "recording",
        "a lost flush: a file of a bag is closed without its summary",
        "ros_pose_stats/node/recording/writer/bag_file.py",
        "end = self._write([mcap_layout.closing(self.contents, self.size)])",
        "end = self.size",
        ("tests/contract/bags/test_drop_film.py",),
    ),
    Mutation(
        "ros",
        "a dropped lock: two nodes have one state file",
        "ros_pose_stats/node/state/tables.py",
        "fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)",
        "pass",
        ("tests/contract/node/restart/test_lives.py",),
    ),
    Mutation(
        "commands",
        "an exit status: a run that Ctrl-C has ended is told as complete",
        "ros_pose_stats/tools/commands/running.py",
        "return INTERRUPTED if interrupted else 0",
        "return 0",
        ("tests/contract/commands/test_interrupts.py",),
    ),
)


def mutate(checkout: Path, mutation: Mutation) -> str:
    """Put the mistake into a file; returns what was in it.

    Raises ValueError if the text is not there once, so that there is nothing to mutate.
    """
    file = checkout / mutation.file
    before = file.read_text("utf-8") if file.exists() else ""
    if before.count(mutation.text) != 1:
        raise ValueError(
            f"{mutation.room}: expected {mutation.text!r} once in {mutation.file}, "
            f"found {before.count(mutation.text)} times; name the code as it is now"
        )
    file.write_text(before.replace(mutation.text, mutation.instead), "utf-8")
    return before


def run(
    checkout: Path, *arguments: str, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run a module of a checkout."""
    return subprocess.run(
        [sys.executable, "-m", *arguments],
        cwd=checkout,
        capture_output=True,
        text=True,
        env={
            **os.environ,
            "PYTHONPATH": str(checkout),
            "PATIENCE": PATIENCE,
            **environment,
        },
    )


def failure(checkout: Path, mutation: Mutation) -> tuple[str, str] | None:
    """The first test named for a mutation that fails, and its ring; None where all pass.

    Raises RuntimeError if the tests cannot be run.
    """
    done = run(
        checkout,
        "pytest",
        "-x",
        "-q",
        "-p",
        "no:cacheprovider",
        "-m",
        "not long",
        *mutation.tests,
        **mutation.environment,
    )
    failed = FAILED.search(done.stdout)
    if done.returncode and not failed:
        raise RuntimeError(
            f"pytest ended with status {done.returncode}: "
            f"{done.stdout[-1000:]}{done.stderr[-1000:]}"
        )
    return (failed[1], failed[2]) if failed else None


def tried(checkout: Path, mutation: Mutation) -> bool:
    """Make one mistake, print which test sees it, and take it back; whether one does."""
    begin = time.monotonic()
    before = mutate(checkout, mutation)
    try:
        caught = failure(checkout, mutation)
    finally:
        (checkout / mutation.file).write_text(before, "utf-8")
    by = f"{caught[1]}: {caught[0]}" if caught else "NOT CAUGHT"
    print(
        f"{mutation.room} | {mutation.mistake} | {by} | {time.monotonic() - begin:.0f} s",
        flush=True,
    )
    return caught is not None


def main() -> int:
    """Try all mutations, or those of some rooms."""
    parser = argparse.ArgumentParser(prog="lab.trials.mutations", description=__doc__)
    parser.add_argument(
        "--only",
        nargs="+",
        metavar="ROOM",
        help="mutations of these rooms alone",
        choices=[mutation.room for mutation in MUTATIONS],
    )
    only = parser.parse_args().only
    chosen = [mutation for mutation in MUTATIONS if not only or mutation.room in only]
    with tempfile.TemporaryDirectory(prefix="mutations_") as folder:
        checkout = Path(folder) / "checkout"
        for name in COPIED:
            shutil.copytree(ROOT / name, checkout / name)
        shutil.copy(ROOT / "setup.cfg", checkout)
        run(checkout, "ros_pose_stats", "compile")
        for mutation in chosen:
            if failed := failure(checkout, mutation):
                sys.exit(f"{failed[0]} fails without a mutation; mend that first")
        caught = sum(tried(checkout, mutation) for mutation in chosen)
    print(f"{caught} of {len(chosen)} mutations caught")
    return 0 if caught >= LEAST * len(chosen) else 1


if __name__ == "__main__":
    raise SystemExit(main())
