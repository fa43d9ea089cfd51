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

"""The answers of a checkout, made by a process of its own in a chosen environment."""

import json
import os
import subprocess
import sys
from pathlib import Path

from tests.golden import answers, parts
from tests.running import ROOT

KEPT = Path(__file__).with_name("kept.json")

REAL = ROOT.parent / "shared"
"""Meshes that were not made for this project; without them their answers are not
compared.
"""

CATALOGUE = (
    "Cf1i",
    "Cf4i",
    "Cl2o",
    "Cs1o",
    "Rf2i",
    "Rl4i",
    "Sf2o",
    "Sl1i",
    "Tf1o",
    "Ts4i",
)


def write_parts(folder):
    """Fill a folder with the kept parts, and of the real ones where they are at
    hand.
    """
    parts.write(folder)
    real = folder / "real"
    real.mkdir()
    for file in [
        *(REAL / "meshes").glob("*.*"),
        *(REAL / "catalogue" / f"{name}.STEP" for name in CATALOGUE),
    ]:
        if file.is_file() and file.suffix != ".md":
            (real / file.name).symlink_to(file)
    return folder


def answers_of(folder, *arguments, checkout=ROOT, environment=None):
    """Answers by request; `arguments` as of the script `answers`."""
    folder.mkdir(exist_ok=True)
    write_parts(folder / "parts")
    output = folder / "answers.json"
    outcome = subprocess.run(
        [sys.executable, "-W", "ignore", answers.__file__, "parts", output, *arguments],
        capture_output=True,
        text=True,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(checkout), **(environment or {})},
    )
    assert outcome.returncode == 0, outcome.stderr
    return json.loads(output.read_text(encoding="utf-8"))
