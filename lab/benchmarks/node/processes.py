"""Processes that say `ready`, the node or the bare one beside it, and their start and
end.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple
from unittest.mock import patch

from domain_coordinator import domain_id
from ros_pose_stats_msgs.srv import CancelDropSimulation, ListDropSimulations

from lab.frame.results import Row, Section

from .bare import SERVICE
from .client import Client

ROOT = Path(__file__).resolve().parents[3]
PATIENCE = 180.0
"""The first start on a machine compiles the kernels."""


class Child:
    """Runs a Python module until the end of the context, which sends SIGINT.

    Parameters
    ----------
    module : str
    *arguments : str

    Attributes
    ----------
    started : float
        Time on the performance counter.
    seconds_to_ready, seconds_to_end : float
        From the start to the line that ends in `ready`, and from SIGINT to the exit.
    """

    def __init__(self, module: str, *arguments: str) -> None:
        self._module = module
        self._lines: deque[str] = deque(maxlen=20)
        self._is_ready = threading.Event()
        self.seconds_to_ready = self.seconds_to_end = 0.0
        self.started = time.perf_counter()
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments],
            cwd=ROOT,
            stderr=subprocess.STDOUT,
            stdout=subprocess.PIPE,
            text=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self) -> Child:
        self._is_ready.wait(PATIENCE)
        if not self.seconds_to_ready:
            self._process.kill()
            raise RuntimeError(self.complaint("is not ready"))
        return self

    def __exit__(self, *_: Any) -> None:
        begin = time.perf_counter()
        self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(30.0)
        finally:
            self._process.kill()
            self._process.wait()
        self.seconds_to_end = time.perf_counter() - begin
        self._reader.join()

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def kill(self) -> None:
        """End it at once, without a chance to tidy up."""
        self._process.kill()
        self._process.wait()

    def complaint(self, problem: str) -> str:
        """A message with the last lines of the process."""
        return "\n".join([f"{self._module} {problem}", *self._lines])

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            if says_ready(line) and not self._is_ready.is_set():
                self.seconds_to_ready = time.perf_counter() - self.started
                self._is_ready.set()
            self._lines.append(line.rstrip())
        self._is_ready.set()  # the process has ended, so nobody shall wait


def says_ready(line: str) -> bool:
    """Whether a line says that the process answers."""
    return line.split()[-1:] == ["ready"]


def node(
    log_directory: Path, mesh_topics: Sequence[str] = (), workers: int = 0
) -> Child:
    """Start the node with bags in a folder of its own."""
    values = {
        "log_directory": str(log_directory),
        "restore": "false",
        "workers": str(workers),
    }
    if mesh_topics:
        values["mesh_topics"] = f"[{', '.join(mesh_topics)}]"
    arguments = [
        word for name, value in values.items() for word in ("-p", f"{name}:={value}")
    ]
    return Child("ros_pose_stats", "node", "--ros-args", *arguments)


def bare() -> Child:
    """Start the process beside the node that does nothing."""
    return Child("lab.benchmarks.node.bare")


@contextmanager
def surroundings() -> Iterator[Path]:
    """Set up the environment of this process and its children, and yield an empty
    folder.
    """
    with (
        tempfile.TemporaryDirectory(prefix="ros_pose_stats_") as name,
        _domain() as domain,
    ):
        folder = Path(name)
        variables = {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(folder / "ros_log"),
            "ROS_PYTHON_CHECK_FIELDS": "0",
        }
        with patch.dict(os.environ, variables):
            yield folder


@contextmanager
def _domain() -> Iterator[int]:
    """Reserve a domain that nobody else on this machine uses; `domain_id` hides an
    OSError.
    """
    reserved = domain_id()
    number = reserved.__enter__()
    try:
        yield number
    finally:
        reserved.__exit__(None, None, None)


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


TIMED = (
    "From starting the process, its kernels compiled before, to the line that says "
    "`ready`; to the first answer of a service to a client that waits for it, which "
    "includes that the middleware of the two finds each other; and from SIGINT to the "
    "end. `bare`: a process that imports rclpy and the messages and has one service, "
    "in turns with the node. Seconds."
)
NODE = "node"
BARE = "bare"
CALLS = {
    NODE: (ListDropSimulations, "list_drop_simulations"),
    BARE: (CancelDropSimulation, SERVICE),
}


class Life(NamedTuple):
    """Seconds to `ready`, to the first answer, and from SIGINT to the end."""

    ready: float
    answer: float
    end: float


def starting(folder: Path, runs: int) -> Section:
    """A row for the node and one for the bare process.

    Parameters
    ----------
    folder : Path
        For the bags.
    runs : int
    """
    with node(folder):
        pass  # compiles the kernels where that was not done
    begin = {NODE: lambda: node(folder), BARE: bare}
    lives: dict[str, list[Life]] = {name: [] for name in begin}
    for _ in range(runs):
        for name, of_process in lives.items():
            of_process.append(_life(begin[name], CALLS[name]))
    return Section(
        "node_start",
        "Start of the node",
        TIMED,
        tuple(_row(name, of_process) for name, of_process in lives.items()),
    )


def _life(begin: Callable[[], Child], call: tuple[type, str]) -> Life:
    kind, name = call
    with Client() as client:
        with begin() as child:
            client.call(kind, name, kind.Request())
            answer = time.perf_counter() - child.started
        return Life(child.seconds_to_ready, answer, child.seconds_to_end)


def _row(name: str, lives: list[Life]) -> Row:
    ready, answer, end = (median(times) for times in zip(*lives, strict=True))
    return Row(
        name,
        {
            "runs": len(lives),
            "ready": ready,
            "least": min(lives).ready,
            "first answer": answer,
            "end": end,
        },
    )
