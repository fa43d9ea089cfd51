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

"""A dataset in memory: bodies, their stable poses, and the drops that ended in each."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lab.bodies.random_polyhedra import RandomPolyhedron
from ros_pose_stats.base.errors import RequestError
from ros_pose_stats.core.records import Index, Part
from ros_pose_stats.core.resting.poses import RestingPoses, resting_poses

from ..errors.simulated_poses import SimulatedPoses
from .archive import Arrays, read_archive
from .spec import DatasetError, DatasetSpec

SAME_DOWN = 1e-9
"""Angle, in radians, within which a pose of a body is the pose in the file."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """Simulated pose statistics of many bodies.

    Attributes
    ----------
    spec : DatasetSpec
    arrays : dict of arrays
        Those of `archive.FIELDS`.
    """

    spec: DatasetSpec
    arrays: Arrays

    @cached_property
    def body(self) -> Index:
        """Number of the body of each pose (P,)."""
        return np.repeat(np.arange(self.spec.bodies), self.arrays["poses"])

    @cached_property
    def pose_starts(self) -> Index:
        """Where each body's poses begin, and their end (B + 1,)."""
        return _starts(self.arrays["poses"])

    def polyhedron(self, number: int) -> RandomPolyhedron:
        """One of the bodies."""
        vertices = self._vertex_starts
        triangles = self._triangle_starts
        return RandomPolyhedron(
            self.arrays["vertex"][vertices[number] : vertices[number + 1]],
            self.arrays["triangle"][triangles[number] : triangles[number + 1]].astype(
                np.int64
            ),
            self.arrays["center_of_mass"][number],
            int(self.arrays["redraws"][number]),
        )

    def part(self, number: int) -> Part:
        """One of the bodies as a part, a unit being a metre."""
        return self.polyhedron(number).part()

    def resting(self, number: int) -> RestingPoses:
        """Stable poses of one of the bodies, in the order of the counts.

        Raises
        ------
        DatasetError
            If they are not those in the file.
        """
        poses = resting_poses(self.part(number), 0.0, 0)
        span = slice(self.pose_starts[number], self.pose_starts[number + 1])
        expected = self.arrays["down"][span]
        downs = np.array([pose.down for pose in poses.poses])
        if (
            downs.shape != expected.shape
            or not np.abs(downs - expected).max() <= SAME_DOWN
        ):
            raise DatasetError(
                "the stable poses in the file",
                f"others of body {number}",
                "make the dataset anew with this version",
            )
        return poses

    def simulated(self, restitution: float, drops: int | None = None) -> SimulatedPoses:
        """Counts of the first drops at one restitution.

        Parameters
        ----------
        restitution : float
            One of the dataset's.
        drops : int, optional
            Number for each body, the end of a block. Default: all.

        Raises
        ------
        RequestError
            If the dataset has no such restitution, or no block ends there.
        """
        return self.blocks(restitution, 0, self._blocks(drops))

    def remaining_drops(self, restitution: float, drops: int) -> SimulatedPoses:
        """Counts of the drops after the first ones; see `simulated`."""
        return self.blocks(restitution, self._blocks(drops), len(self.spec.block_ends))

    def blocks(self, restitution: float, first: int, end: int) -> SimulatedPoses:
        """Counts of the drops of blocks first ... end - 1."""
        if restitution not in self.spec.restitutions:
            raise RequestError(
                f"a restitution out of {self.spec.restitutions}",
                f"{restitution}",
                "the dataset holds no other",
            )
        row = self.spec.restitutions.index(restitution)
        count = self.arrays["count"][:, row, first:end].sum(axis=1, dtype=np.int64)
        settled = self.arrays["settled"][:, row, first:end].sum(axis=1, dtype=np.int64)
        return SimulatedPoses(self.body, count, settled[self.body])

    def _blocks(self, drops: int | None) -> int:
        ends = self.spec.block_ends
        if drops is not None and drops not in ends:
            raise RequestError(
                f"a number of drops at the end of a block of {self.spec.block}",
                f"{drops}",
                f"the dataset has {self.spec.drops} of each body",
            )
        return len(ends) if drops is None else ends.index(drops) + 1

    @cached_property
    def _vertex_starts(self) -> Index:
        return _starts(self.arrays["vertices"])

    @cached_property
    def _triangle_starts(self) -> Index:
        return _starts(self.arrays["triangles"])


def read_dataset(file: str | Path) -> Dataset:
    """Read a dataset.

    Raises
    ------
    DatasetError
        If it cannot be read, is of another kind, or contradicts itself.
    """
    return Dataset(*read_archive(Path(file)))


def _starts(lengths: NDArray[np.uint32]) -> Index:
    return np.concatenate(([0], np.cumsum(lengths, dtype=np.int64)))


FOLDER = Path(__file__).resolve().parents[1] / "data"

SHIPPED = ((0.0, "inertia"), (0.25, "inertia"), (0.65, "second"), (1.0, "inertia"))
"""Shift scale and moment of each."""


def shipped_file(shift: float, shift_moment: str) -> Path:
    """Where a reference dataset lies.

    Raises
    ------
    DatasetError
        If none of that shift comes with the package.
    """
    if (shift, shift_moment) not in SHIPPED:
        shifts = ", ".join(f"{one:g} ({moment})" for one, moment in SHIPPED)
        raise DatasetError(
            f"a shift of {shifts}",
            f"{shift:g} ({shift_moment})",
            "make one with `python -m study dataset` and give it with --dataset",
        )
    return FOLDER / f"polyhedra_{abs(shift):g}_{shift_moment}.npz"  # of -0.0 too


def shipped_dataset(shift: float = 0.0, shift_moment: str = "inertia") -> Dataset:
    """A reference dataset: 1 057 bodies, 1 000 drops of each at restitution 0.2, 0.5,
    0.8.
    """
    return read_dataset(shipped_file(shift, shift_moment))


def shipped_datasets() -> list[Dataset]:
    """All reference datasets, by rising shift."""
    return [shipped_dataset(*shift) for shift in SHIPPED]
