"""A process that does what it is handed, one thing at a time.

It reads functions with their arguments from its standard input and writes what they returned to
its standard output, both pickled. It ends with its input, also in the middle of its work: nothing
is left behind by a run that was killed.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

READY = b"ready"

FIRST_TO_GO = "1000"
"""Of all processes, when the memory of the machine is used up."""

Asked = tuple[Callable[..., Any], tuple[Any, ...]]


def work(requests: BinaryIO, answers: BinaryIO) -> None:
    """Do what is asked for, until there is nothing more to read."""
    waiting: queue.SimpleQueue[Asked] = queue.SimpleQueue()

    def read() -> None:
        try:
            while True:
                waiting.put(pickle.load(requests))
        except (EOFError, pickle.UnpicklingError):  # whoever asked is gone
            os._exit(0)
        except Exception:  # what was asked for cannot be loaded here
            traceback.print_exc()
            os._exit(1)

    threading.Thread(target=read, name="requests", daemon=True).start()
    while True:
        function, arguments = waiting.get()
        try:
            found = function(*arguments)
        except BaseException:  # at a usual end Python would wait for the thread that reads
            traceback.print_exc()
            os._exit(1)
        answer(answers, found)


def answer(answers: BinaryIO, found: object) -> None:
    """Tell whoever asked; end where nobody is left."""
    try:
        pickle.dump(found, answers, pickle.HIGHEST_PROTOCOL)
        answers.flush()
    except BrokenPipeError:
        os._exit(0)


def take_answers() -> BinaryIO:
    """Where answers go; be the first to end where memory is short."""
    with suppress(OSError):  # a system without it
        Path("/proc/self/oom_score_adj").write_text(FIRST_TO_GO)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever prints must not come between the answers
    return answers


def main() -> None:
    """Say that it is there, and work."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever started it decides
    answers = take_answers()
    answer(answers, READY)
    work(sys.stdin.buffer, answers)
