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

"""A node through lives that end well or not, while disks fill, clocks jump and clients
die.
"""

import atexit
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from random import Random
from statistics import median
from typing import NamedTuple

from ros_pose_stats import part_from_mesh
from tests.contract.node.harness.transports import LOOPBACK

from ..cell import MEGABYTE, flat
from ..frame import Outcome, Setting
from . import lanes
from .life import Life, node_of
from .told import SEVERAL, SURFACES, Told

CALLS = 150_000
SHORT_LIVES = 10
LONG_SHARE = 0.9
FAULT = 150
"""Of a full run: calls, lives that end soon, the share of calls in the long one; and
the calls that a fault lasts.
"""

WARM_SECONDS = 600.0
MOST_GROWTH = 5.0
"""MiB that memory may grow by after the longest life's first ten minutes."""

LOOKS = 5
ENOUGH = 12
"""Looks at the memory between two faults, and how many of them are judged at least."""

ANCHOR = "anchor"


class Span(NamedTuple):
    """A life to be: calls, faults, and whether it is killed."""

    calls: int
    faults: int
    killed: bool


def plan(setting):
    """Short lives, killed and stopped in turns, and a long one that sees every
    fault.
    """
    calls = setting.of(CALLS, 3000)
    lives = setting.of(SHORT_LIVES, 3)
    short = max(400, round((1.0 - LONG_SHARE) * calls / lives))
    return [
        *(Span(short, 1, number % 2 == 0) for number in range(lives)),
        Span(round(LONG_SHARE * calls), max(4, setting.of(15)), False),
    ]


class Soak:
    """Lives of the node on one log directory, run when their first outcome is asked
    for.
    """

    def __init__(self):
        self.told = Told()
        self._lives = 0
        self._memory = []
        self._next_fault = 0
        self._anchor = ""

    def trials(self):
        """A row for each thing that is judged."""
        return self.calls, self.answers, self.bags, self.memory

    def calls(self, setting: Setting) -> Outcome:
        """Eleven clients at work at once through lives of the node that are killed or
        stopped, the disk full, the folder moved away, the clock set back and clients
        killed: every call is answered.
        """
        if not self._lives:
            self._live(setting)
        record = self.told
        numbers = self.told.events
        estimates = sorted(record.seconds["estimate"]) or [0.0]
        summary = (
            f"{self._lives} lives; "
            + ", ".join(f"{numbers[name]} {name}" for name in sorted(numbers))
            + f"; an estimate takes {1e3 * median(estimates):.0f} ms, the slowest of a "
            f"hundred {1e3 * estimates[int(0.99 * len(estimates))]:.0f} ms"
        )
        return Outcome(sum(map(len, record.seconds.values())), record.wrong[:], summary)

    def answers(self, setting: Setting) -> Outcome:
        """Estimates and simulations, those that were cancelled too, are number for
        number the library's.
        """
        self.calls(setting)
        bad = self.told.unlike_the_library()
        simulated = self.told.events["simulations"]
        return Outcome(
            len(self.told.estimates) + simulated,
            bad[:SEVERAL],
            f"{len(self.told.estimates)} estimates, {simulated} simulations, "
            f"{len(bad)} unlike the library's",
        )

    def bags(self, setting: Setting) -> Outcome:
        """Results, acceptances and ends that clients were told without NOT_RECORDED are
        in the bags, each end once.
        """
        self.calls(setting)
        lost = self.told.not_in([*sorted(self._folder.glob("moved_*")), self._bags])
        messages = (
            len(self.told.answers) + len(self.told.accepted) + len(self.told.ended)
        )
        return Outcome(
            messages,
            lost[:SEVERAL],
            f"{messages} told, {len(lost)} not as they should be in "
            f"{self.told.events['messages in bags']} messages",
        )

    def memory(self, setting: Setting) -> Outcome:
        """Resident memory of the longest life, flat after its first ten minutes."""
        self.calls(setting)
        minutes = self._memory[-1][0] / 60.0
        sizes = [
            size / MEGABYTE for seconds, size in self._memory if seconds > WARM_SECONDS
        ]
        if len(sizes) < ENOUGH:
            size = self._memory[-1][1] / MEGABYTE
            return Outcome(1, [], f"{size:.0f} MiB after {minutes:.0f} min: not judged")
        third = len(sizes) // 3
        growth = median(sizes[-third:]) - median(sizes[:third])
        summary = (
            f"{median(sizes):.0f} MiB after ten minutes ({min(sizes):.0f} to "
            f"{max(sizes):.0f}), {growth:+.1f} MiB from the first third to the last of "
            f"{minutes:.0f} min"
        )
        return Outcome(len(sizes), [summary] * (growth > MOST_GROWTH), summary)

    def _live(self, setting):
        folder = tempfile.TemporaryDirectory(prefix="soak_")
        atexit.register(folder.cleanup)
        self._folder = Path(folder.name)
        self._bags = self._folder / "bags"
        self._clock = self._folder / "clock"
        self._clock.write_text("0", "utf-8")
        self._chance = Random(setting.seed)
        for span in plan(setting):
            self._lives += 1
            node = node_of(self._bags, self._clock, max_drops=10**7)
            try:
                self._one_life(Life(node, self.told, self._chance.random()), span)
            finally:
                node.kill()

    def _one_life(self, life, span):
        try:
            self._look_for_anchor(life)
            life.start(lanes.ALL)
            start = time.monotonic()
            pieces = max(5, span.faults + 1)
            for piece in range(pieces):
                for _ in range(LOOKS):
                    life.go_on(span.calls // (pieces * LOOKS))
                    if not span.killed and span.faults > 1:
                        self._memory.append((time.monotonic() - start, life.memory))
                if piece < span.faults:
                    self._fault(life)
            self._drop_anchor(life)
        finally:
            life.end(span.killed)
        self.told.events["kills" if span.killed else "stops"] += 1

    def _fault(self, life):
        faults = (self._full_disk, self._no_folder, self._clock_back, self._dead_client)
        faults[self._next_fault % len(faults)](life)
        self._next_fault += 1
        self.told.events["faults"] += 1

    def _full_disk(self, life):
        """No file may grow for a while."""
        sizes = [path.stat().st_size for path in self._bags.rglob("*.mcap")]
        for limit in (max(sizes, default=0), resource.RLIM_INFINITY):
            resource.prlimit(
                life.node.process.pid,
                resource.RLIMIT_FSIZE,
                (limit, resource.RLIM_INFINITY),
            )
            life.go_on(FAULT)

    def _no_folder(self, life):
        """Somebody moves the log directory away."""
        if self._bags.exists():
            self._bags.rename(self._folder / f"moved_{time.monotonic_ns():020d}")

    def _clock_back(self, life):
        """The clock is set back by another hour."""
        shift = float(self._clock.read_text("utf-8")) - 3600.0
        self._clock.write_text(f"{shift}", "utf-8")

    def _dead_client(self, life):
        """A client is killed in the middle of its calls."""
        with subprocess.Popen(
            [sys.executable, "-m", f"{__package__}.peer"],
            text=True,
            stdout=subprocess.PIPE,
            env={**os.environ, **LOOPBACK},
        ) as peer:
            assert peer.stdout.readline() == "ready\n"
            life.go_on(round(FAULT * self._chance.random()))
            peer.kill()

    def _drop_anchor(self, life):
        """Estimate a part that the next life must know, with a mesh of its own."""
        vertices, triangles = SURFACES[0]
        surface = ((1.0 + 0.01 * self._lives) * vertices, triangles)
        answer = life.ask("estimate", part=flat(surface, ANCHOR))
        is_known = answer.success and self.told.result(answer.statistics)
        self._anchor = part_from_mesh(*surface).digest if is_known else ""

    def _look_for_anchor(self, life):
        if self._anchor:
            answer = life.ask("get_statistics", part_id=ANCHOR)
            if [statistics.part_digest for statistics in answer.statistics] != [
                self._anchor
            ]:
                self.told.wrong.append(
                    "the part of the last life is not there: "
                    f"{answer.message or 'another mesh'}"
                )
