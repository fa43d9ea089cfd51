"""From the start of the node's process to its first answer."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import NamedTuple

from ros_pose_stats_msgs.srv import CancelDropSimulation, ListDropSimulations

from ..results import Row, Section
from .bare import SERVICE
from .child import Child, bare, node
from .client import Client

TIMED = (
    "From starting the process, its kernels compiled before, to the line that says `ready`; to "
    "the first answer of a service to a client that waits for it, which includes that the "
    "middleware of the two finds each other; and from SIGINT to the end. `bare`: a process that "
    "imports rclpy and the messages and has one service, in turns with the node. Seconds.")
NODE, BARE = "node", "bare"
CALLS = {NODE: (ListDropSimulations, "list_drop_simulations"),
         BARE: (CancelDropSimulation, SERVICE)}


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
        for name, found in lives.items():
            found.append(_life(begin[name], CALLS[name]))
    return Section("node_start", "Start of the node", TIMED,
                   tuple(_row(name, found) for name, found in lives.items()))


def _life(begin: Callable[[], Child], call: tuple[type, str]) -> Life:
    kind, name = call
    with Client() as client:
        with begin() as child:
            client.call(kind, name, kind.Request())
            answer = time.perf_counter() - child.started
        return Life(child.seconds_to_ready, answer, child.seconds_to_end)


def _row(name: str, lives: list[Life]) -> Row:
    ready, answer, end = (median(each) for each in zip(*lives, strict=True))
    return Row(name, {"runs": len(lives), "ready": ready, "least": min(lives).ready,
                      "first answer": answer, "end": end})
