"""A soak from its plan to its tables."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from typing import NamedTuple
from unittest.mock import patch

from ros_pose_stats_msgs import srv

from benchmarks.node import jobs
from benchmarks.node.client import Client
from benchmarks.node.processes import surroundings
from benchmarks.report import DOCS, machine, table, write_page
from benchmarks.results import Results, Section, save
from ros_pose_stats import part_from_mesh

from . import lanes
from .bodies import BODIES
from .checks import compare_estimates, compare_simulations, recorded
from .faults import Surroundings
from .life import Life, node
from .sections import sections
from .tally import Tally

SHORT_SHARE = 0.4
"""Of the time that is spent in lives that end soon; the rest is one long one."""

KILLED, STOPPED = "node killed and restarted", "node stopped and restarted"
ANCHOR = "anchor"

UDP_ONLY = {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
"""Killed processes would leave their shared memory behind."""


class Span(NamedTuple):
    """A life to be: how long, how many faults in it, and how it ends."""

    seconds: float
    faults: int
    end: str


def plan(minutes: float) -> list[Span]:
    """Short lives, killed and stopped in turns, and a long one."""
    seconds = 60.0 * minutes
    short = max(2, round(2.0 * minutes))
    spans = [Span(SHORT_SHARE * seconds / short, 1, (KILLED, STOPPED)[k % 2])
             for k in range(short)]
    return [*spans, Span((1.0 - SHORT_SHARE) * seconds, max(4, round(3.0 * minutes)), "")]


class Soak:
    """Lives of the node on one log directory.

    Parameters
    ----------
    folder : Path
    seed : int
    """

    def __init__(self, folder: Path, seed: int) -> None:
        self.around = Surroundings(folder)
        self.tally = Tally()
        self._chance = Random(seed)
        self._began = time.monotonic()
        self._anchor = ""
        self._next_fault = 0

    def live(self, number: int, span: Span) -> None:
        """One life."""
        with (node(self.around.bags, self.around.clock) as child, Client() as client,
              jobs.action_client(client) as action):
            life = Life(child, client, action, self.tally, self._chance, number, self._began)
            try:
                self._look_for_anchor(life)
                life.start(lanes.ALL)
                for _ in range(span.faults):
                    life.run_for(span.seconds / (span.faults + 1))
                    self._fault(life)
                life.run_for(span.seconds / (span.faults + 1))
                self._drop_anchor(life, number)
            except (TimeoutError, RuntimeError) as error:
                raise RuntimeError(child.complaint(str(error))) from error
            if span.end:
                self.tally.faults[span.end] += 1
            if span.end == KILLED:
                child.kill()
                life.last_words()
            life.end()

    def _fault(self, life: Life) -> None:
        faults = self.around.faults()
        name = list(faults)[self._next_fault % len(faults)]
        self._next_fault += 1
        self.tally.faults[name] += 1
        faults[name](life)

    def _drop_anchor(self, life: Life, number: int) -> None:
        """Estimate a part that the next life must know, with a mesh of its own."""
        request = srv.EstimatePoses.Request()
        vertices = (1.0 + 0.01 * number) * BODIES[0].vertices
        jobs.carry(request, ANCHOR, vertices, BODIES[0].triangles)
        answer = life.client.call(srv.EstimatePoses, "estimate", request)
        known = jobs.accepted(answer) and self.tally.told(answer.statistics)
        self._anchor = part_from_mesh(vertices, BODIES[0].triangles).digest if known else ""

    def _look_for_anchor(self, life: Life) -> None:
        if self._anchor:
            answer = life.client.call(srv.GetStatistics, "get_statistics",
                                      srv.GetStatistics.Request(part_id=ANCHOR))
            found = [statistics.part_digest for statistics in answer.statistics]
            if found != [self._anchor]:
                self.tally.wrong.append(f"life {life.number}: the part of the last life is not "
                                        f"there: {answer.message or 'another mesh'}")


def soak(minutes: float, seed: int = 1,
         said: Callable[[str], object] = lambda _: None) -> tuple[Tally, list[Section]]:
    """Soak the node and judge it."""
    with surroundings() as folder, patch.dict(os.environ, UDP_ONLY):
        work = Soak(folder, seed)
        for number, span in enumerate(plan(minutes)):
            work.live(number, span)
            said(f"life {number}: {sum(map(len, work.tally.seconds.values()))} calls so far, "
                 f"{len(work.tally.wrong)} wrong")
        tally = work.tally
        found = recorded(work.around.log_directories, tally)
        bad = {"estimates": compare_estimates(tally), "simulations": compare_simulations(tally)}
        return tally, sections(tally, found, bad, len(lanes.ALL))


def main(arguments: Sequence[str] | None = None) -> int:
    """Soak, print, and return the exit status: 1 where anything was wrong."""
    parser = argparse.ArgumentParser(prog="tests.soak.node", description=__doc__)
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", action="store_true",
                        help="store docs/benchmarks/node_soak.json and render docs/benchmarks.md")
    options = parser.parse_args(arguments)
    if not options.minutes > 0.0:
        parser.error("give minutes above 0")
    where = machine()
    tally, tables = soak(options.minutes, options.seed, print)
    for section in tables:
        print(f"\n{section.title}\n{table(section)}")
    print(*(f"WRONG: {wrong}" for wrong in tally.wrong), sep="\n")
    if options.write:
        save(Results(where, tuple(tables)), DOCS / "benchmarks" / "node_soak.json")
        print(write_page(DOCS))
    return 1 if tally.wrong else 0
