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

"""A process that does one thing at a time, and may be ended at any moment.

It reads functions with their arguments from its standard input and writes what they
returned to its standard output, both pickled. It ends with its input, also in the
middle of its work: nothing is left behind by a run that was killed.
"""

import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

from .errors import BatchError, reason

Made = TypeVar("Made")

READY = b"ready"
FIRST_TO_GO = "1000"  # of all processes, when the memory of the machine is used up
STEP_SECONDS = 1.0  # most of a time limit that is lost each time a run is suspended
START_SECONDS = 60.0
"""In which a process says that it is there; a machine may have much to do."""

PREPARE_SECONDS = 900.0
"""In which it prepares itself: without a cache, kernels are compiled."""

IDLE_SECONDS = 60.0
"""After which a process that nobody needs gives its memory back by ending."""

# `-m` would search the current folder first, where somebody else's files may lie.
_PROGRAM = "import sys; sys.path[:] = {path!a}; from {module} import main; main()"


class ProcessDiedError(Exception):
    """A process ended in the middle of a piece; how, in words."""


class TookLongError(ProcessDiedError):
    """A process was ended because its piece took too long."""


class WorkerProcess:
    """A process that does one thing at a time; BatchError if it cannot be started."""

    def __init__(self, seconds: float = START_SECONDS) -> None:
        program = _PROGRAM.format(path=sys.path, module=__name__)
        # Ctrl-C reaches all processes of a terminal, and whoever started this one
        # decides.
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            try:
                self._process = subprocess.Popen(
                    [sys.executable, "-c", program],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                )
            finally:
                signal.pthread_sigmask(signal.SIG_SETMASK, mask)
            with self._ended_after(seconds):
                ready = self._read()
        except (OSError, ProcessDiedError) as error:
            raise BatchError(
                "a process to work in",
                reason(error),
                "see what it printed above, or end others that use up the memory",
            ) from error
        assert ready == READY

    def call(self, function: Callable[..., Made], *arguments: Any) -> Made:
        """Have a function of a module called there."""
        assert self._process.stdin is not None
        try:
            pickle.dump(
                (function, arguments), self._process.stdin, pickle.HIGHEST_PROTOCOL
            )
            self._process.stdin.flush()
        except (OSError, ValueError) as error:  # closed by `kill`
            raise self._died() from error
        answer: Made = self._read()
        return answer

    def call_within(
        self, seconds: float, function: Callable[..., Made], *arguments: Any
    ) -> Made:
        """Have a function called there; the process ends if that takes longer."""
        with self._ended_after(seconds):
            return self.call(function, *arguments)

    @contextmanager
    def _ended_after(self, seconds: float) -> Iterator[None]:
        """End the process if what is done meanwhile takes longer."""
        is_done = threading.Event()
        is_late = threading.Event()

        def guard() -> None:
            remaining = seconds
            # In steps, so that a run that is suspended does not grow old.
            while remaining > 0.0:
                if is_done.wait(min(remaining, STEP_SECONDS)):
                    return
                remaining -= STEP_SECONDS
            is_late.set()
            self._process.kill()

        threading.Thread(target=guard, name="time limit", daemon=True).start()
        try:
            yield
        except ProcessDiedError as error:
            if is_late.is_set():
                raise TookLongError(f"took longer than {seconds:g} s") from error
            raise
        finally:
            is_done.set()

    def is_alive(self) -> bool:
        """Whether it has not ended."""
        return self._process.poll() is None

    def kill(self) -> None:
        """End it, whatever it is at; whoever waits for it gets a ProcessDiedError."""
        self._process.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            assert stream is not None
            with suppress(OSError):  # what was never read
                stream.close()

    def _read(self) -> Any:
        assert self._process.stdout is not None
        try:
            return pickle.load(self._process.stdout)
        except (EOFError, OSError, ValueError, pickle.UnpicklingError) as error:
            raise self._died() from error

    def _died(self) -> ProcessDiedError:
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(1.0)
        status = self._process.poll()
        if status is not None and status < 0:
            return ProcessDiedError(f"ended by {signal.Signals(-status).name}")
        return ProcessDiedError(f"ended with exit status {status}")


class Worker:
    """A process while somebody needs it, for one caller after the other."""

    def __init__(self, prepare: Callable[[], object]) -> None:
        self._prepare = prepare
        self._turn = threading.Lock()
        self._process: WorkerProcess | None = None
        self._idle = threading.Timer(IDLE_SECONDS, self._end_idle)
        self.closed = False

    def call_within(
        self, seconds: float, function: Callable[..., Made], *arguments: Any
    ) -> Made:
        """Have a function called there; after a TookLongError in a new process."""
        with self._turn:
            self._idle.cancel()
            try:
                return self._running().call_within(seconds, function, *arguments)
            except ProcessDiedError:
                self._drop()
                raise
            finally:
                self._idle = threading.Timer(IDLE_SECONDS, self._end_idle)
                self._idle.daemon = True
                self._idle.start()

    def close(self) -> None:
        """End the process, whatever it is at; there will be no other."""
        self.closed = True
        process = self._process
        if process is not None:
            process.kill()

    def _running(self) -> WorkerProcess:
        if self._process is not None and not self._process.is_alive():
            self._drop()
        if self._process is None:
            process = self._process = WorkerProcess()
            try:
                process.call_within(PREPARE_SECONDS, self._prepare)
            except TookLongError as error:  # which is not for the piece that waits
                raise BatchError(
                    "a process that is ready to work",
                    f"one that {error}",
                    "see what it printed above",
                ) from error
        if self.closed:
            raise ProcessDiedError("is closed")
        return self._process

    def _end_idle(self) -> None:
        with self._turn:
            if threading.current_thread() is self._idle:  # else it was needed again
                self._drop()

    def _drop(self) -> None:
        if self._process is not None:
            self._process.kill()
        self._process = None


def main() -> None:
    """Say that it is ready, and answer requests until its input ends."""
    with suppress(OSError):  # a system without it
        Path("/proc/self/oom_score_adj").write_text(FIRST_TO_GO)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever prints must not come between the answers
    _answer(answers, READY)
    requests: queue.SimpleQueue[tuple[Callable[..., Any], tuple[Any, ...]]] = (
        queue.SimpleQueue()
    )
    threading.Thread(
        target=_read_requests, args=(requests,), name="requests", daemon=True
    ).start()
    while True:
        function, arguments = requests.get()
        try:
            answer = function(*arguments)
        except BaseException:
            # At a usual end Python would wait for the thread that reads.
            traceback.print_exc()
            os._exit(1)
        _answer(answers, answer)


def _read_requests(requests: queue.SimpleQueue[Any]) -> None:
    try:
        while True:
            requests.put(pickle.load(sys.stdin.buffer))
    except (EOFError, pickle.UnpicklingError):  # whoever asked is gone
        os._exit(0)
    except Exception:  # what was asked for cannot be loaded here
        traceback.print_exc()
        os._exit(1)


def _answer(answers: BinaryIO, answer: object) -> None:
    try:
        pickle.dump(answer, answers, pickle.HIGHEST_PROTOCOL)
        answers.flush()
    except BrokenPipeError:  # nobody is left
        os._exit(0)
