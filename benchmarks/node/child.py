"""A process that says `ready`: the node, or the bare one beside it."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
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
            [sys.executable, "-m", module, *arguments], cwd=ROOT, stderr=subprocess.STDOUT,
            stdout=subprocess.PIPE, text=True)
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
        """Of the process."""
        return self._process.pid

    def kill(self) -> None:
        """End it at once, without a chance to tidy up."""
        self._process.kill()
        self._process.wait()

    def complaint(self, what: str) -> str:
        """A message with the last lines of the process."""
        return "\n".join([f"{self._module} {what}", *self._lines])

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            if says_ready(line) and not self._is_ready.is_set():
                self.seconds_to_ready = time.perf_counter() - self.started
                self._is_ready.set()
            self._lines.append(line.rstrip())
        self._is_ready.set()  # has ended: nobody shall wait


def says_ready(line: str) -> bool:
    """Whether a process says with a line that it answers."""
    return line.split()[-1:] == ["ready"]


def node(log_directory: Path, mesh_topics: Sequence[str] = (), workers: int = 0) -> Child:
    """The node with bags in a folder of its own."""
    values = {"log_directory": str(log_directory), "restore": "false", "workers": str(workers)}
    if mesh_topics:
        values["mesh_topics"] = f"[{', '.join(mesh_topics)}]"
    given = [word for name, value in values.items() for word in ("-p", f"{name}:={value}")]
    return Child("ros_pose_stats", "node", "--ros-args", *given)


def bare() -> Child:
    """The process beside it that does nothing."""
    return Child("benchmarks.node.bare")
