"""Parts that no fit has seen, each dropped often enough to know its probabilities."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lab.bodies.families import FAMILIES, family_options, family_part, family_poses
from ros_pose_stats import DropScene, Part, PoseStatistics, simulate
from ros_pose_stats.core.planning.confidence import pose_prior
from ros_pose_stats.core.resting.poses import RestingPoses
from ros_pose_stats.core.simulation.drops import DropChunk
from ros_pose_stats.core.statistics.prior import PosePrior

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SERIES = 4242
"""Seed of the parts; the reference datasets and the fits have others."""

KINDS = FAMILIES
"""Families of the parts, which take turns."""

RESTITUTIONS = (0.2, 0.5, 0.8)
SEQUENCE = 10_000
REFERENCE = 20_000


class Case(NamedTuple):
    """A part at one restitution.

    Attributes
    ----------
    number : int
        Number of the part in the series, in which the families take turns.
    restitution : float
    sequence : (SEQUENCE,) array of int
        Poses of successive drops; -1 for an unsettled one.
    reference : (P,) array of int
        Counts of other drops, `REFERENCE` of them in the benchmark.
    """

    number: int
    restitution: float
    sequence: NDArray[np.int16]
    reference: Index

    @property
    def family(self) -> str:
        """Family of the part."""
        return KINDS[self.number % len(KINDS)]

    def part(self) -> Part:
        """Make the part anew, with nothing prepared."""
        return family_part(self.family, SERIES, self.number)

    def counts(self, drops: int) -> Index:
        """Counts (P,) of the first drops, of those that settled."""
        first = self.sequence[:drops]
        return np.bincount(first[first >= 0], minlength=self.reference.size)

    def prior(self) -> PosePrior:
        """Prior around the estimate that `hybrid` starts from."""
        return pose_prior(self.resting(), self.scene())

    def resting(self) -> RestingPoses:
        """Stable poses of a new part."""
        return family_poses(self.family, self.part())

    @property
    def options(self) -> dict[str, Any]:
        """What counts as a pose and as round, for the functions of the library."""
        tolerance, sides = family_options(self.family)
        return {"cluster_tolerance": tolerance, "round_sides": sides}

    def scene(self) -> DropScene:
        """Scene in which the part is dropped, with what counts as a pose and as round."""
        return DropScene(self.restitution, None, **self.options)

    def square_error(self, probability: Array) -> float:
        """Mean square error over the poses, the reference's noise taken off."""
        s = self.reference / self.reference.sum()
        noise = s * (1.0 - s) / (self.reference.sum() - 1)
        return float(np.mean(np.square(probability - s) - noise))


def probabilities(found: PoseStatistics) -> Array:
    """Probabilities (P,) by `index`."""
    return np.array(
        [pose.probability for pose in sorted(found.poses, key=lambda one: one.index)]
    )


def drop_parts(
    parts: int,
    say: Callable[[str], object],
    restitutions: Sequence[float] = RESTITUTIONS,
    reference: int | None = None,
) -> list[Case]:
    """Drop that many parts at every restitution; without a number `REFERENCE` times to judge."""
    drops = REFERENCE if reference is None else reference
    cases = []
    for number in range(parts):
        cases += [
            _drop_part(number, restitution, drops) for restitution in restitutions
        ]
        if number % 10 == 9:
            say(f"{number + 1} of {parts} parts are dropped")
    return cases


def _drop_part(number: int, restitution: float, reference_drops: int) -> Case:
    empty = Case(number, restitution, np.zeros(0, np.int16), np.zeros(0, np.int64))
    part = empty.part()
    outcomes = []

    def on_drops(chunk: DropChunk) -> None:
        outcomes.append(chunk.outcomes.pose.astype(np.int16))

    simulate(
        part, SEQUENCE, restitution, 1000 + number, on_drops=on_drops, **empty.options
    )
    reference = simulate(
        part, reference_drops, restitution, 900_000 + number, **empty.options
    )
    counts = [pose.count for pose in sorted(reference.poses, key=lambda one: one.index)]
    return empty._replace(sequence=np.concatenate(outcomes), reference=np.array(counts))


def write_cases(cases: Sequence[Case], file: Path) -> None:
    """Write cases, which take the longest to make, for another run."""
    np.savez_compressed(
        file,
        number=[one.number for one in cases],
        family=[one.family for one in cases],
        poses=[one.reference.size for one in cases],
        restitution=[one.restitution for one in cases],
        sequence=np.array([one.sequence for one in cases]),
        reference=np.concatenate([one.reference for one in cases]),
    )


def read_cases(file: Path) -> list[Case]:
    """Read what `write_cases` wrote.

    Raises
    ------
    ValueError
        If the parts were of other families.
    """
    with np.load(file) as found:
        if "family" not in found.files:
            raise ValueError(
                f"cases with families expected, {file} has none; remove it"
            )
        cases = list(_cases({name: found[name] for name in found.files}))
        if [one.family for one in cases] != found["family"].tolist():
            raise ValueError(
                f"parts of {KINDS[0]}, {KINDS[1]}, ... expected, {file} has others; "
                f"remove it"
            )
    return cases


def _cases(found: dict[str, NDArray[np.generic]]) -> Iterator[Case]:
    counts = np.split(found["reference"], np.cumsum(found["poses"])[:-1])
    for number, restitution, sequence, reference in zip(
        found["number"], found["restitution"], found["sequence"], counts, strict=True
    ):
        yield Case(int(number), float(restitution), sequence, reference)
