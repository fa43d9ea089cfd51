"""The ring of truths holds under every kernel of OpenBLAS that the processor can
run.
"""

import os
import subprocess
import sys

import pytest

from tests.golden.machines import PLAYED
from tests.running import ROOT


@pytest.mark.long
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("kernel", [name for name in PLAYED if name.startswith("BLAS")])
def test_truths_hold(kernel):
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
        env={**os.environ, **PLAYED[kernel]},
        capture_output=True,
        text=True,
    )
    assert outcome.returncode == 0, outcome.stdout[-4000:]
