"""How long large bad inputs take, each in a process that may be ended."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from multiprocessing.connection import Connection

from ros_pose_stats import PoseStatsError, estimate_all, part_from_mesh
from ros_pose_stats.shapes import box

from .large_meshes import CASES
from .trial import Outcome
from .watched import Job, Watched, answer

BOUND = 60.0
"""Seconds that any of them may take to be made, taken as a part and estimated nine times."""


def attempt_large(name: str, *_: object) -> Outcome:
    """Make a large input, hand it over and ask for all estimates."""
    vertices, triangles = CASES[name]()
    begin = time.perf_counter()
    try:
        part = part_from_mesh(vertices, triangles)
        made = time.perf_counter() - begin
        poses = len(estimate_all(part)[0].poses)
    except PoseStatsError as error:
        return Outcome(name, len(triangles), f"refused: expected {error.expected}",
                       seconds=time.perf_counter() - begin)
    told = f"{poses} poses; {made:.2f} s of it for the part"
    return Outcome(name, len(triangles), compared=told, seconds=time.perf_counter() - begin)


def serve_large(connection: Connection) -> None:
    """Try the large inputs that are asked for."""
    warnings.simplefilter("error")
    estimate_all(part_from_mesh(*box(1.0, 2.0, 3.0)))  # compiles
    answer(connection, attempt_large)


def large_outcomes() -> Iterator[Outcome]:
    """What became of each large input; its seed is the number of triangles."""
    with Watched(BOUND, serve_large) as watched:
        yield from watched.outcomes(Job(name, 0) for name in CASES)


def large_table() -> tuple[str, bool]:
    """A line for each large input, and whether all of them ended in time."""
    lines = [f"{'input':18} {'triangles':>9} {'seconds':>9}  outcome"]
    passed = True
    for found in large_outcomes():
        passed = passed and not found.faults
        said = "; ".join(found.faults) or found.refusal or found.compared
        lines.append(f"{found.kind:18} {found.seed:9} {found.seconds:9.2f}  {said}")
    return "\n".join(lines), passed
