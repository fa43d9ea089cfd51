"""Parts that no fit has seen, each dropped often enough to know its probabilities."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats import DropScene, Part, PoseStatistics, resting_poses, simulate
from ros_pose_stats.geometry.shapes.random_polyhedra import random_polyhedron
from ros_pose_stats.planning import pose_prior
from ros_pose_stats.simulation.drops import DropChunk
from ros_pose_stats.statistics.posterior import PosePrior

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SERIES = 4242
"""Seed of the random polyhedra; the reference datasets have others."""

SHIFTS = ((0.0, "inertia"), (0.25, "inertia"), (0.65, "second"), (1.0, "inertia"))
RESTITUTIONS = (0.2, 0.5, 0.8)
SEQUENCE, REFERENCE = 10_000, 20_000
TOLERANCE = 0.0


class Case(NamedTuple):
    """A part at one restitution.

    Attributes
    ----------
    number : int
        Of the part in its series; the shifts take turns.
    restitution : float
    sequence : (SEQUENCE,) array of int
        Pose of one drop after the other.
    reference : (P,) array of int
        Counts of `REFERENCE` other drops.
    """

    number: int
    restitution: float
    sequence: NDArray[np.int16]
    reference: Index

    def part(self) -> Part:
        """A new one, with nothing remembered."""
        return random_polyhedron(SERIES, self.number, *SHIFTS[self.number % len(SHIFTS)]).part()

    def counts(self, drops: int) -> Index:
        """Of the first drops (P,)."""
        return np.bincount(self.sequence[:drops], minlength=self.reference.size)

    def prior(self) -> PosePrior:
        """What the base estimate says."""
        return pose_prior(resting_poses(self.part(), TOLERANCE),
                          DropScene(self.restitution, None, TOLERANCE))

    def square_error(self, probability: Array) -> float:
        """Mean square error over the poses, the reference's noise taken off."""
        s = self.reference / self.reference.sum()
        noise = s * (1.0 - s) / (self.reference.sum() - 1)
        return float(np.mean(np.square(probability - s) - noise))


def probabilities(found: PoseStatistics) -> Array:
    """By index (P,)."""
    return np.array([pose.probability for pose in sorted(found.poses, key=lambda one: one.index)])


def dropped(parts: int, said: Callable[[str], object]) -> list[Case]:
    """Drop that many parts at every restitution."""
    cases = []
    for number in range(parts):
        cases += [_dropped(number, restitution) for restitution in RESTITUTIONS]
        if number % 10 == 9:
            said(f"{number + 1} of {parts} parts are dropped")
    return cases


def _dropped(number: int, restitution: float) -> Case:
    empty = Case(number, restitution, np.zeros(0, np.int16), np.zeros(0, np.int64))
    part, outcomes = empty.part(), []

    def on_drops(chunk: DropChunk) -> None:
        outcomes.append(chunk.outcomes.pose.astype(np.int16))

    simulate(part, SEQUENCE, restitution, 1000 + number, cluster_tolerance=TOLERANCE,
             on_drops=on_drops)
    reference = simulate(part, REFERENCE, restitution, 900_000 + number,
                         cluster_tolerance=TOLERANCE)
    counts = [pose.count for pose in sorted(reference.poses, key=lambda one: one.index)]
    return empty._replace(sequence=np.concatenate(outcomes), reference=np.array(counts))


def store(cases: Sequence[Case], file: Path) -> None:
    """Keep cases, which take the longest to make, for another run."""
    np.savez_compressed(
        file, number=[one.number for one in cases], poses=[one.reference.size for one in cases],
        restitution=[one.restitution for one in cases],
        sequence=np.array([one.sequence for one in cases]),
        reference=np.concatenate([one.reference for one in cases]))


def stored(file: Path) -> list[Case]:
    """What `store` kept."""
    with np.load(file) as found:
        return list(_cases({name: found[name] for name in found.files}))


def _cases(found: dict[str, NDArray[np.generic]]) -> Iterator[Case]:
    counts = np.split(found["reference"], np.cumsum(found["poses"])[:-1])
    for number, restitution, sequence, reference in zip(
            found["number"], found["restitution"], found["sequence"], counts, strict=True):
        yield Case(int(number), float(restitution), sequence, reference)
