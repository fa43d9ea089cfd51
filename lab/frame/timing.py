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

"""Contenders timed in turns, so that other load of the machine affects all of them
alike.
"""

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any, TypeVar

Answer = TypeVar("Answer")


@dataclass(frozen=True)
class Contender:
    """A call to time, and its preparation.

    Attributes
    ----------
    name : str
    call : callable
        Timed; its argument is what `prepare` returns.
    prepare : callable
        Runs before each call, untimed, and makes what the call uses up.
    collected : bool
        Whether the garbage collector runs during the call. trimesh copies the hull for
        each pose, in cycles; uncollected, the copies of a large body fill the memory.
    """

    name: str
    call: Callable[[Any], object]
    prepare: Callable[[], Any] = lambda: None
    collected: bool = False


@dataclass(frozen=True)
class Pace:
    """How long to measure: up to `rounds`, each contender for about `patience`
    seconds.
    """

    rounds: int
    patience: float


class Timings:
    """Seconds of each contender, round by round."""

    def __init__(self, seconds: dict[str, list[float]]) -> None:
        self.seconds = seconds

    def median(self, name: str) -> float:
        """Median seconds."""
        return median(self.seconds[name])

    def milliseconds(self, name: str) -> float:
        """Median milliseconds."""
        return 1e3 * self.median(name)

    def ratio(self, first: str, second: str) -> float:
        """Median over the rounds of one contender's time by another's in the same
        round.
        """
        pairs = zip(self.seconds[first], self.seconds[second], strict=False)
        return median(first_time / second_time for first_time, second_time in pairs)


def race(contenders: Sequence[Contender], pace: Pace) -> Timings:
    """Time the contenders A B C, A B C, ... and leave out those whose patience is used
    up.

    As in `timeit`, the garbage collector is off during a call: a full collection goes
    through all objects of the compiler and takes tens of milliseconds, in the same call
    of every round.
    """
    seconds: dict[str, list[float]] = {contender.name: [] for contender in contenders}
    gc.collect()
    gc.freeze()
    try:
        for _ in range(pace.rounds):
            for contender in contenders:
                if sum(seconds[contender.name]) < pace.patience:
                    seconds[contender.name].append(_once(contender))
    finally:
        gc.unfreeze()
    return Timings(seconds)


def timed(call: Callable[[], Answer]) -> tuple[Answer, float]:
    """What a call returns, and its processor time in seconds, of all threads.

    Other load of the machine hardly counts in it. The garbage collector is off during
    the call, as in `race`.
    """
    is_enabled = gc.isenabled()
    gc.disable()
    try:
        begin = time.process_time()
        answer = call()
        return answer, time.process_time() - begin
    finally:
        if is_enabled:
            gc.enable()


def _once(contender: Contender) -> float:
    ready = contender.prepare()
    gc.collect()
    if not contender.collected:
        gc.disable()
    try:
        begin = time.perf_counter()
        result = contender.call(ready)
        elapsed = time.perf_counter() - begin
    finally:
        gc.enable()
    del result  # freeing it is not timed
    return elapsed
