"""The node under attack: its memory, its disk, and how long its answers take."""

from __future__ import annotations

import os
import threading
import time
from contextlib import contextmanager
from pathlib import Path

from domain_coordinator import domain_id

from tests.ros.harness.cell import cell_of
from tests.ros.harness.client import wait_for

MEGABYTE = 2**20


@contextmanager
def own_domain(folder):
    """A domain of this machine alone, its logs below a folder; yields its number."""
    ros = Path(__file__).resolve().parents[2] / "ros"
    os.environ |= {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_PYTHON_CHECK_FIELDS": "0",
                   "FASTRTPS_DEFAULT_PROFILES_FILE": str(ros / "quick_discovery.xml"),
                   "ROS_LOG_DIR": str(folder)}
    with domain_id() as number:
        os.environ["ROS_DOMAIN_ID"] = str(number)
        yield number


def attacked(domain, log_directory, **values):
    """A ready node in a namespace of its own, and a client of it."""
    return cell_of(domain, log_directory, "attacked", **values)


def resident(node, name="VmRSS"):
    """Resident bytes of a node; `VmHWM`: the most since the last `forget_peak`."""
    for line in Path(f"/proc/{node.process.pid}/status").read_text().splitlines():
        if line.startswith(f"{name}:"):
            return 1024 * int(line.split()[1])
    raise AssertionError(f"no {name} of the node: has it ended?")


def forget_peak(node):
    """Let `VmHWM` begin anew."""
    Path(f"/proc/{node.process.pid}/clear_refs").write_text("5")


def disk(folder):
    """Bytes of all files below a folder; what is deleted meanwhile counts nothing."""
    total = 0
    for path in folder.rglob("*"):
        try:
            total += path.stat().st_size if path.is_file() else 0
        except FileNotFoundError:
            continue
    return total


class Stopwatch:
    """Times the calls of one service, one after the other, in a thread.

    Parameters
    ----------
    client : Client
    make : callable
        Gives the fields of the next call of `~/estimate`.
    pause : float
        Seconds between calls.
    """

    def __init__(self, client, make, pause=0.02):
        self.seconds, self.refused = [], []
        self._client, self._make, self._pause = client, make, pause
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join()

    def _run(self):
        while not self._over.is_set():
            fields = self._make()
            begin = time.monotonic()
            answer = wait_for(self._client.send("estimate", **fields))
            self.seconds.append(time.monotonic() - begin)
            if not answer.success:
                self.refused.append(answer.message)
            self._over.wait(self._pause)


def percentile(seconds, share):
    """The value that a share of the calls stay below, milliseconds."""
    ordered = sorted(seconds)
    return 1000.0 * ordered[min(len(ordered) - 1, int(share * len(ordered)))]
