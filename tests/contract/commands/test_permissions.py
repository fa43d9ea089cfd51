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

"""What a user may not read or write is refused in one line that names it."""

import json
import os
import shutil
import subprocess
import sys

import pytest

from lab.bodies import shapes
from tests.answers import write_stl

# Modes do not stop root, unless it lacks the two rights that say so.
BOUND = ("setpriv", "--bounding-set", "-dac_override,-dac_read_search")
PROGRAM = """\
import json, sys
from tests.running import call
print(json.dumps([call(*words) for words in json.load(sys.stdin)]))
"""
PART = "--unit", "mm"
COMMANDS = {
    "closed.stl": ("estimate", "closed.stl", *PART),
    "closed.obj": ("estimate", "closed.obj", *PART),
    "closed.step": ("estimate", "closed.step"),
    "shut/part.stl": ("compare", "part.stl", "shut/part.stl", *PART),
    "closed.csv": ("fit", "closed.csv", "--plate", "glass", "--plates", "plates.yaml"),
    "bag/run.mcap": ("bag", "bag"),
    "shut": ("catalogue", "shut", "-o", "pages"),
    "sealed": ("report", "part.stl", *PART, "-o", "sealed/page.html"),
}
"""By the path that is to be named."""


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    """What each command says where modes hold, all of them in one process."""
    if os.geteuid() == 0 and shutil.which(BOUND[0]) is None:
        pytest.skip("root, and no setpriv to bind it")
    folder = tmp_path_factory.mktemp("modes")
    write_stl(folder / "part.stl", shapes.box(20.0, 30.0, 40.0))
    for name in ("shut", "sealed", "bag"):
        (folder / name).mkdir()
    closed = [folder / f"closed.{ending}" for ending in ("stl", "obj", "step", "csv")]
    for file in (*closed, folder / "bag/run.mcap", folder / "shut/part.stl"):
        shutil.copy(folder / "part.stl", file)
        file.chmod(0o000)
    (folder / "shut").chmod(0o000)
    (folder / "sealed").chmod(0o555)
    bound = BOUND if os.geteuid() == 0 else ()
    try:
        outcome = subprocess.run(
            [*bound, sys.executable, "-c", PROGRAM],
            input=json.dumps(list(COMMANDS.values())),
            cwd=folder,
            capture_output=True,
            text=True,
            check=True,
        )
    finally:
        for name in ("shut", "sealed"):
            (folder / name).chmod(0o755)
    return dict(zip(COMMANDS, json.loads(outcome.stdout), strict=True))


@pytest.mark.long
@pytest.mark.parametrize("path", COMMANDS)
def test_it_is_refused_with_the_path_and_the_reason(outcomes, path):
    status, printed, complaint = outcomes[path]
    assert (status, printed) == (2, "")
    [line] = complaint.splitlines()
    assert line.startswith("ros_pose_stats: expected ")
    assert path in line and "Permission denied" in line
