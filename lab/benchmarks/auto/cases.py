"""Parts that no fit has seen, each dropped often enough to know its probabilities."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lab.bodies.families import FAMILIES, family_options, family_part
from ros_pose_stats import Part, PoseStatistics, simulate

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SERIES = 4242
"""Seed of the parts; the reference datasets and the fits have others."""

RESTITUTIONS = (0.2, 0.5, 0.8)
REFERENCE = 20_000


class Case(NamedTuple):
    """A part at one restitution.

    Attributes
    ----------
    number : int
        Number of the part in the series, in which the families take turns.
    restitution : float
    reference : (P,) array of int
        Counts of its drops.
    """

    number: int
    restitution: float
    reference: Index

    @property
    def family(self) -> str:
        """Family of the part."""
        return FAMILIES[self.number % len(FAMILIES)]

    def part(self) -> Part:
        """Make the part anew, with nothing prepared."""
        return family_part(self.family, SERIES, self.number)

    @property
    def options(self) -> dict[str, Any]:
        """What counts as a pose and as round, for the functions of the library."""
        tolerance, sides = family_options(self.family)
        return {"cluster_tolerance": tolerance, "round_sides": sides}

    def square_error(self, probability: Array) -> float:
        """Mean square error over the poses, the reference's noise taken off."""
        share = self.reference / self.reference.sum()
        noise = share * (1.0 - share) / (self.reference.sum() - 1)
        return float(np.mean(np.square(probability - share) - noise))


def by_index(statistics: PoseStatistics, name: str) -> Array:
    """A number of each pose (P,) by `index`."""
    poses = sorted(statistics.poses, key=lambda pose: pose.index)
    return np.array([getattr(pose, name) for pose in poses])


def drop_parts(parts: int) -> Iterator[Case]:
    """Drop that many parts at every restitution."""
    for number in range(parts):
        for restitution in RESTITUTIONS:
            case = Case(number, restitution, np.zeros(0, np.int64))
            reference = simulate(
                case.part(), REFERENCE, restitution, 900_000 + number, **case.options
            )
            yield case._replace(reference=by_index(reference, "count"))
        if number % 10 == 9:
            print(f"{number + 1} of {parts} parts are dropped")
