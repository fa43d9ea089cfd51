"""What the demo starts ends with it."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.running import ROOT

PATIENCE = 60.0
STARTS_ONE = """
import sys, time
sys.path.insert(0, ".ci")
from demo_cell import end_like_ctrl_c, process
end_like_ctrl_c()
with process("http.server", "0") as child:
    print(child.pid, flush=True)
    time.sleep(600.0)
"""


def is_there(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_however_the_demo_ends_so_do_its_processes(number):
    def heed_ctrl_c():  # as from a terminal, even if these tests run in the background
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    demo = subprocess.Popen([sys.executable, "-c", STARTS_ONE], cwd=ROOT, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                            preexec_fn=heed_ctrl_c)
    child = int(demo.stdout.readline())
    try:
        assert is_there(child)
        demo.send_signal(number)
        demo.wait(PATIENCE)
        end = time.monotonic() + PATIENCE
        while is_there(child) and time.monotonic() < end:
            time.sleep(0.05)
        assert not is_there(child)
    finally:
        demo.stdout.close()
        if is_there(child):
            os.kill(child, signal.SIGKILL)
