"""Builds parts in a process of its own, which whoever started it may end at any moment.

It reads requests from its standard input and writes what came of them to its standard output,
both pickled. It ends with its input, also in the middle of its work: nothing is left behind by a
node that was killed.
"""

from __future__ import annotations

import os
import pickle
import queue
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from ...errors import PoseStatsError
from ...estimators import estimate
from ...kernels.compilation import all_kernels, prepare_kernels
from ...mesh.decimation import visible_triangles
from ...methods import AUTO
from ...records import DropScene, Part
from .part_requests import PartRequest, part_of

NICENESS = 10
"""Drops and answers come first."""

FIRST_TO_GO = "1000"
"""Of all processes, when the memory of the machine is used up."""


class BuildRequest(NamedTuple):
    """A mesh, or a part that is built already, and the scene of its first estimate."""

    request: PartRequest | Part
    scene: DropScene


class Built(NamedTuple):
    """A part with all that was prepared on the way to its first estimate and picture."""

    part: Part
    prepared: dict[Any, Any]


def build(asked: BuildRequest) -> Built | PoseStatsError | str:
    """Build a part as far as its first estimate and its first picture.

    Returns
    -------
    Built, PoseStatsError or str
        The refusal of a bad mesh, or what failed inside the program.
    """
    try:
        part = asked.request if isinstance(asked.request, Part) else part_of(asked.request)
        estimate(part, AUTO, cluster_tolerance=asked.scene.cluster_tolerance,
                 round_sides=asked.scene.round_sides)
        visible_triangles(part)  # for its markers
        return Built(part, part.all_prepared())
    except PoseStatsError as refusal:
        return refusal
    except Exception as error:  # belongs to whoever asked
        return f"{type(error).__name__}: {error}"


def work(requests: BinaryIO, answers: BinaryIO) -> None:
    """Build what is asked for, until there is nothing more to read."""
    waiting: queue.SimpleQueue[BuildRequest] = queue.SimpleQueue()

    def read() -> None:
        with suppress(EOFError, pickle.UnpicklingError):  # whoever asked is gone
            while True:
                waiting.put(pickle.load(requests))
        os._exit(0)

    threading.Thread(target=read, name="requests", daemon=True).start()
    _answer(answers, "ready")
    while True:
        _answer(answers, build(waiting.get()))


def _answer(answers: BinaryIO, found: object) -> None:
    try:
        pickle.dump(found, answers, pickle.HIGHEST_PROTOCOL)
        answers.flush()
    except BrokenPipeError:
        os._exit(0)


def main() -> None:
    """Give way to others, load the kernels, and work."""
    os.nice(NICENESS)
    with suppress(OSError):  # a system without it
        Path("/proc/self/oom_score_adj").write_text(FIRST_TO_GO)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever prints must not come between the answers
    all_kernels()
    prepare_kernels()
    work(sys.stdin.buffer, answers)


if __name__ == "__main__":
    main()
