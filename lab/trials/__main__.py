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

"""All programs of trials in a short form with a fixed seed, two side by side.

    python -m lab.trials [--size SHARE]

From size 1 on times are judged, so that one program follows the other. Exit status 1
where a promise was broken.
"""

import argparse
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

from . import ROOT
from .frame import TITLES, judges_times


def tried(name: str, size: float | None) -> bool:
    """Run one, with its name before each line; whether all promises were kept."""
    options = ["--short"] if size is None else ["--size", f"{size:g}"]
    with subprocess.Popen(
        [sys.executable, "-m", f"lab.trials.{name}", *options],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    ) as process:
        for line in process.stdout or ():
            print(f"{name}: {line}", end="", flush=True)
    return process.returncode == 0


def main() -> int:
    """Run them with the size that was asked for."""
    parser = argparse.ArgumentParser(prog="lab.trials")
    parser.add_argument("--size", type=float, help="share of the full numbers")
    size = parser.parse_args().size
    side_by_side = 1 if size is not None and judges_times(size) else 2
    with ThreadPoolExecutor(side_by_side) as pool:
        kept = dict(
            zip(TITLES, pool.map(lambda name: tried(name, size), TITLES), strict=True)
        )
    broken = [name for name in TITLES if not kept[name]]
    print(f"broken: {', '.join(broken)}" if broken else "all promises kept")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
