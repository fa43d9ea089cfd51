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
