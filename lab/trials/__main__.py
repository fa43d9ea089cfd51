"""All programs of trials, one after the other, in a short form with a fixed seed.

    python -m lab.trials [--size SHARE]

Some ten minutes on two cores. Exit status 1 where a promise was broken.
"""

from __future__ import annotations

import subprocess
import sys

from . import ROOT
from .frame import TITLES


def main() -> int:
    """Run them with the options that were given; by default `--short`."""
    options = sys.argv[1:] or ["--short"]
    broken = [
        name
        for name in TITLES
        if subprocess.run(
            [sys.executable, "-m", f"lab.trials.{name}", *options], cwd=ROOT
        ).returncode
        != 0
    ]
    print(f"broken: {', '.join(broken)}" if broken else "all promises kept")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
