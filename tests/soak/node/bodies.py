"""The parts of the soak, and what the library says of them."""

from __future__ import annotations

from array import array
from functools import cache, cached_property
from typing import Any

import numpy as np
from ros_pose_stats_msgs.msg import PartMesh

from benchmarks.bodies import random_polyhedron
from ros_pose_stats import Part, estimate, part_from_mesh, simulate

SIZE = 0.02
METHODS = ("combined", "csae", "area")
RESTITUTIONS = (0.2, 0.5)

Counts = dict[int, int]


class SoakBody:
    """A small part under a name of its own.

    Attributes
    ----------
    part_id : str
    vertices, triangles : arrays
    """

    def __init__(self, number: int) -> None:
        made = random_polyhedron(8 + number % 5, number + 1)
        self.part_id = f"part_{number}"
        self.vertices = SIZE * made.vertices
        self.triangles = made.triangles

    def message(self, part_id: str | None = None) -> PartMesh:
        """As a client sends it."""
        made = PartMesh(part_id=self.part_id if part_id is None else part_id)
        made.vertices = array("d", np.ascontiguousarray(self.vertices).tobytes())
        made.triangles = array("I", self.triangles.astype(np.uint32).tobytes())
        return made

    @cached_property
    def part(self) -> Part:
        """As the library has it."""
        return part_from_mesh(self.vertices, self.triangles, part_id=self.part_id)


BODIES = tuple(SoakBody(number) for number in range(10))


@cache
def estimated(number: int, method: str, restitution: float) -> dict[int, float]:
    """Probabilities by pose."""
    found = estimate(BODIES[number].part, method, restitution=restitution)
    return {pose.index: pose.probability for pose in found.poses}


@cache
def simulated(number: int, drops: int, restitution: float, seed: int) -> Counts:
    """Counts by pose."""
    return counted(simulate(BODIES[number].part, drops, restitution, seed, workers=1))


def counted(statistics: Any) -> Counts:
    """Counts of a result, of the library or in a message; poses that never came left out."""
    return {pose.index: pose.count for pose in statistics.poses if pose.count}


def prefixes(number: int, restitution: float, seed: int, sizes: list[int]) -> dict[int, Counts]:
    """Counts of the first so many drops of one run, for several numbers."""
    poses: dict[int, Any] = {}
    simulate(BODIES[number].part, max(sizes), restitution, seed, workers=1,
             on_drops=lambda chunk: poses.update({chunk.first: chunk.outcomes.pose.copy()}))
    row = np.concatenate([poses[first] for first in sorted(poses)])
    return {size: _of(row[:size]) for size in sizes}


def _of(poses: Any) -> Counts:
    values, counts = np.unique(poses[poses >= 0], return_counts=True)
    return dict(zip(values.tolist(), counts.tolist(), strict=True))
