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

"""The pictures of docs/designing.md: `python -m lab.demo.designing`.

The scripts of that page save its bracket while `report --watch` follows the file. What
the terminal and the page say of each version is printed, and Chromium draws the page at
the first and at the last version.
"""

import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import IO, Any
from urllib.request import urlopen

from matplotlib.image import imread

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "designing.md"
FIGURES = ROOT / "docs" / "figures"

CHROMIUM = (
    "chromium",
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--hide-scrollbars",
    "--window-size=1100,950",
    "--timeout=10000",
)
TRIES = 5
BLANK = 0.1
"""Deviation of the pixels of a page that has no picture yet: Chromium may draw it
before it has asked for the first news."""


def main() -> None:
    """Save, follow, print and draw."""
    text = PAGE.read_text(encoding="utf-8")
    scripts = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (line,) = re.findall(r"^ros_pose_stats (.* --watch)$", text, re.MULTILINE)
    words = shlex.split(line)
    names: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        exec(scripts[0], names)
        command = subprocess.Popen(
            [sys.executable, "-m", "ros_pose_stats", *words, "--no-browser"],
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
        try:
            follow(command, scripts, names)
        finally:
            command.terminate()
            command.wait()
            os.chdir(ROOT)


def follow(
    command: subprocess.Popen[str], scripts: list[str], names: dict[str, Any]
) -> None:
    """Save one version after the other, and print and draw what there is to see."""
    assert command.stdout is not None
    address = read_address(command.stdout)
    for version, script in enumerate(scripts, 1):
        if version > 1:
            exec(script, names)
            print(command.stdout.readline().rstrip())
        print(f"  {wait_for_drops(address, version)}", flush=True)
        if version in (1, len(scripts)):
            draw(address, FIGURES / f"designing_{version}.png")


def read_address(terminal: IO[str]) -> str:
    """Print the lines of the start, and return the address among them."""
    for line in terminal:
        print(line.rstrip())
        address = re.search(r"http://\S+/", line)
        if address is not None:
            return address[0]
    sys.exit("designing: the command has ended")


def wait_for_drops(address: str, version: int) -> str:
    """The title of the page once all drops of a version are done."""
    number = -1
    while True:
        with urlopen(f"{address}news?after={number}&version={version}") as answer:
            if answer.status != 200:
                continue
            news = json.load(answer)
        number = news["number"]
        is_dropped = re.search(r"by \d+ drops?<", news["html"])
        if news["version"] == version and is_dropped:
            return str(news["title"])


def draw(address: str, file: Path) -> None:
    """Have Chromium draw the page to a file."""
    for _ in range(TRIES):
        subprocess.run(
            [*CHROMIUM, f"--screenshot={file}", address],
            stderr=subprocess.DEVNULL,
            check=True,
        )
        if imread(file).std() > BLANK:
            return
    sys.exit(f"designing: {file.name} stays blank")


if __name__ == "__main__":
    main()
