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

"""What the demo starts ends with it."""

import os
import signal
import subprocess
import sys
import time

import pytest

from tests.running import ROOT, is_gone

PATIENCE = 60.0
STARTS_ONE = """
import time
from lab.demo.cell import end_like_ctrl_c, process
end_like_ctrl_c()
with process("http.server", "0") as child:
    print(child.pid, flush=True)
    time.sleep(600.0)
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_however_the_demo_ends_so_do_its_processes(number):
    def heed_ctrl_c():  # as from a terminal, even if these tests run in the background
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    demo = subprocess.Popen(
        [sys.executable, "-c", STARTS_ONE],
        cwd=ROOT,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        preexec_fn=heed_ctrl_c,
    )
    child = int(demo.stdout.readline())
    try:
        assert not is_gone(child)
        demo.send_signal(number)
        demo.wait(PATIENCE)
        end = time.monotonic() + PATIENCE
        while not is_gone(child) and time.monotonic() < end:
            time.sleep(0.05)
        assert is_gone(child)
    finally:
        demo.stdout.close()
        if not is_gone(child):
            os.kill(child, signal.SIGKILL)
