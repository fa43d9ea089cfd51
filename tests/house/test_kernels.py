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

"""The ring of truths holds with what libraries use on older processors."""

import os
import subprocess
import sys

import pytest

from tests.golden.machines import MACHINES, OLDEST
from tests.running import ROOT


@pytest.mark.long
@pytest.mark.parametrize("machine", OLDEST)
def test_truths_hold(machine):
    outcome = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "tests/truth",
            "-m",
            "not long",
            "--no-showlocals",
            "-p",
            "no:cacheprovider",
        ],
        cwd=ROOT,
        env={**os.environ, **MACHINES[machine]},
        capture_output=True,
        text=True,
    )
    assert outcome.returncode == 0, outcome.stdout[-4000:]
