"""Builds parts: small ones here, what takes long in processes that can be stopped."""

from __future__ import annotations

import pickle
import subprocess
import threading
import time
from contextlib import suppress
from typing import Any

from ...batch.processes import command_of
from ...errors import MeshError, PoseStatsError, RequestError
from ...mesh.overlap import TakesLongError, within
from ...records import DropScene, Part
from ...resting.poses import are_found
from .building_process import BuildRequest, Built, build, main
from .lanes import Pace
from .part_requests import PartRequest, part_of

LARGE_TRIANGLES = 5000
"""A mesh with more of them may take longer than others should wait."""

CORNERS = 3
"""Vertices a triangle where each has its own."""

HERE_SECONDS = 0.05
"""For looking in the node how the bodies of a mesh lie to each other."""

TRY_SECONDS = 2.0
"""For one mesh before those behind it; if that does not do, it waits for those like it."""

BUDGET_SECONDS = 60.0
"""For one mesh."""

IDLE_SECONDS = 60.0
"""After which the process gives its memory back by ending."""


class NotBuiltError(RequestError):
    """A part that was not built for a reason that is not the mesh's."""


def is_large(request: PartRequest | Part) -> bool:
    """Whether a mesh may take longer than others should wait."""
    return are_many(len(request.triangles), len(request.vertices))


def are_many(triangles: int, vertices: int) -> bool:
    """Whether a mesh of so many triangles and vertices is large."""
    return triangles > LARGE_TRIANGLES or vertices > CORNERS * LARGE_TRIANGLES


class BuildingProcess:
    """A process that builds one part after the other; see `building_process`.

    Starting it returns once it can work.
    """

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            command_of(main), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            start_new_session=True)  # whoever interrupts the node ends it, and this with it
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self._requests, self._answers = self.process.stdin, self.process.stdout

    def wait_until_ready(self) -> None:
        """Wait until it can work: kernels are loaded, or even compiled, before.

        Raises EOFError if it has ended.
        """
        pickle.load(self._answers)

    def ask(self, asked: BuildRequest) -> Any:
        """What it answers.

        Raises EOFError, BrokenPipeError, UnpicklingError if it has ended.
        """
        pickle.dump((build, (asked,)), self._requests, pickle.HIGHEST_PROTOCOL)
        self._requests.flush()
        return pickle.load(self._answers)

    def end(self) -> int:
        """End it at once; its exit status."""
        self.process.kill()
        return self.process.wait()

    def close(self) -> None:
        """End it and let go of its pipes."""
        self.end()
        self._answers.close()
        with suppress(BrokenPipeError):  # of a request that it did not read to its end
            self._requests.close()


class PartBuilder:
    """Builds parts, each within the time of the lane that it is built in."""

    def __init__(self) -> None:
        self._builders = {Pace.MIDDLE: ProcessBuilder(), Pace.SLOW: ProcessBuilder()}

    def build(self, request: PartRequest, scene: DropScene,
              pace: Pace = Pace.SLOW) -> Part:
        """Build a part; one that takes long with its poses.

        Raises PoseStatsError with one line that says what is wrong. Raises TakesLongError if a
        slower lane has to build it.
        """
        if not is_large(request):
            try:
                with within(HERE_SECONDS):
                    return part_of(request)
            except TakesLongError:
                if pace is Pace.QUICK:
                    raise
        found = self._ask(request, scene, pace)
        found.part.keep_all(found.prepared)
        return found.part

    def find_poses(self, part: Part, scene: DropScene, pace: Pace = Pace.SLOW) -> None:
        """Have the poses of a large part at hand; see `build`."""
        if is_large(part) and not are_found(part, scene):
            part.keep_all(self._ask(part, scene, pace).prepared)

    def _ask(self, request: PartRequest | Part, scene: DropScene, pace: Pace) -> Built:
        seconds = BUDGET_SECONDS if pace is Pace.SLOW else TRY_SECONDS
        try:
            return self._builders[pace].build(BuildRequest(request, scene), seconds)
        except TakesLongError as late:
            if pace is not Pace.SLOW:
                raise
            raise MeshError(f"a mesh that is checked within {seconds:g} s",
                            f"{len(request.triangles)} triangles", "decimate it") from late

    def close(self) -> None:
        """End what is being built."""
        for builder in self._builders.values():
            builder.close()


class ProcessBuilder:
    """Builds parts in a process, one at a time."""

    def __init__(self) -> None:
        self._turn = threading.Lock()
        self._process: BuildingProcess | None = None
        self._idle: threading.Timer | None = None
        self._closed = threading.Event()

    def build(self, asked: BuildRequest, seconds: float) -> Built:
        """Build a part with its poses.

        Raises PoseStatsError with one line that says what is wrong. Raises TakesLongError if it
        takes longer than so many seconds.
        """
        with self._turn:
            found = self._built(asked, seconds)
        if isinstance(found, PoseStatsError):
            raise found
        if isinstance(found, str):
            raise RuntimeError(found)
        built: Built = found
        return built

    def _built(self, asked: BuildRequest, seconds: float) -> Any:
        begin, late = time.monotonic(), threading.Event()
        try:
            process = self._running()
            begin = time.monotonic()
            guard = threading.Timer(seconds, self._stop, (process, late))
            guard.daemon = True
            guard.start()
            try:
                return process.ask(asked)
            finally:
                guard.cancel()
                self._rest(process)
        except (EOFError, BrokenPipeError, pickle.UnpicklingError) as error:
            status = self._drop()
            if late.is_set():
                raise TakesLongError from error
            raise self._not_built(status, time.monotonic() - begin) from error

    @staticmethod
    def _stop(process: BuildingProcess, late: threading.Event) -> None:
        late.set()
        process.end()

    def _not_built(self, status: int | None, seconds: float) -> NotBuiltError:
        if self._closed.is_set():
            return NotBuiltError("a running node", "one that is ending", "start it again")
        return NotBuiltError("a process that builds the part to its end",
                             f"one that ended with status {status} after {seconds:.1f} s",
                             "send the mesh again; decimate it if memory is short")

    def _running(self) -> BuildingProcess:
        """The process, started anew where there is none."""
        if self._idle is not None:
            self._idle.cancel()
            self._idle = None
        if self._process is not None and self._process.process.poll() is not None:
            self._drop()
        if self._closed.is_set():
            raise EOFError
        if self._process is None:
            self._process = BuildingProcess()
            if self._closed.is_set():  # meanwhile
                self._process.end()
            self._process.wait_until_ready()
        return self._process

    def _rest(self, process: BuildingProcess) -> None:
        """Have the process end once it has not been used for a while."""
        def end() -> None:
            with self._turn:
                if self._idle is idle and self._process is process:
                    self._drop()

        idle = self._idle = threading.Timer(IDLE_SECONDS, end)
        idle.daemon = True
        idle.start()

    def _drop(self) -> int | None:
        """End the process; its status, None where there is none."""
        process, self._process = self._process, None
        if process is None:
            return None
        process.close()
        return process.process.returncode

    def close(self) -> None:
        """End the process, whatever it computes."""
        self._closed.set()
        process = self._process
        if process is not None:
            process.end()
