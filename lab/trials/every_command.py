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

"""Every command about a part, on files of one's own: what reaches standard error?

    python -m lab.trials.every_command FILE|FOLDER ...

A command prints its answer, or refuses the file in one line of its own. Warnings of
libraries, tracebacks and other statuses than 0 and 2 are printed here, and make the
status 1. Drops are few, for the answers are not looked at.
"""

import argparse
import os
import sys
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path

from lab.benchmarks.files import files_in
from ros_pose_stats.core.kernels.compilation import all_kernels
from ros_pose_stats.tools.cli import main

PART = "PART"
FOLDER = "FOLDER/"
COMMANDS = (
    "estimate PART",
    "estimate PART --json --each",
    "estimate PART --method all",
    "simulate PART --drops 50 --seed 1",
    "report PART -o FOLDER/page.html --png FOLDER/page.png --drops 50 --wanted 0",
    "animate PART -o FOLDER/drop.mcap --seed 1",
    "animate PART -o FOLDER/drop.gif --seed 1",
    "compare PART PART --drops 50 -o FOLDER/comparison.html",
    "flips PART --kick 10mm --flips 20 --wanted 0",
    "feeding PART --wanted 0 --plate 300mm 200mm --flips 20 --kicks 5mm 10mm",
    "sensitivity PART --wanted 0 --drops 50 --checks 1 --suggest --within 1mm",
    "catalogue PART -o FOLDER/catalogue",
    "fit FOLDER/counts.csv --plate tried --plates FOLDER/plates.yaml",
)
OWN = "ros_pose_stats"
"""What each line of the product on standard error begins with."""

STATUSES = (0, 2)


def printed(words: Sequence[str], errors: Path) -> int:
    """Run a command in a copy of this process, with standard error in a file."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    status = 1
    try:
        with errors.open("w") as stream, Path(os.devnull).open("w") as nothing:
            os.dup2(stream.fileno(), 2)
            os.dup2(nothing.fileno(), 1)
            warnings.simplefilter("default")
            status = main(words)
    except SystemExit as end:
        status = int(end.code or 0)
    finally:
        sys.stderr.flush()
        os._exit(status)


def complaints(file: Path, command: str) -> list[str]:
    """Lines of a command about a file that are not its own, and a wrong status."""
    with tempfile.TemporaryDirectory(prefix="trial_") as name:
        folder = Path(name)
        (folder / "counts.csv").write_text(f"part,pose,count\n{file},0,40\n")
        words = [
            str(file) if word == PART else word.replace(FOLDER, f"{folder}/")
            for word in command.split()
        ]
        errors = folder / "errors"
        status = printed(words, errors)
        lines = errors.read_text(errors="backslashreplace").splitlines()
    foreign = [line for line in lines if line and not line.startswith(OWN)]
    return foreign + [f"status {status}"] * (status not in STATUSES)


def tried(files: Sequence[Path], commands: Sequence[str]) -> int:
    """Run commands on every file; how many said what they should not."""
    for kernel in all_kernels():
        kernel.prepare()
    broken = 0
    for file in files:
        for command in commands:
            lines = complaints(file, command)
            broken += bool(lines)
            for line in lines:
                print(f"{file.name}, {command}: {line}", flush=True)
    print(f"{len(files)} files, {len(commands)} commands, {broken} broken", flush=True)
    return broken


def parsed() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="lab.trials.every_command", description=(__doc__ or "").partition("\n")[0]
    )
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE|FOLDER")
    names = sorted({command.split()[0] for command in COMMANDS})
    parser.add_argument("--only", nargs="+", choices=names, default=names)
    return parser.parse_args()


if __name__ == "__main__":
    options = parsed()
    chosen = [command for command in COMMANDS if command.split()[0] in options.only]
    raise SystemExit(1 if tried(files_in(options.files), chosen) else 0)
