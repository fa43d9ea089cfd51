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

"""The specification of a dataset, checked before anything runs."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from lab.bodies.random_polyhedra import check_shift
from ros_pose_stats.base.errors import PoseStatsError, RequestError
from ros_pose_stats.core.records import DropScene
from ros_pose_stats.core.records.scene import describe_scene

PAPER_BODIES = 1057
PAPER_DROPS = 100
PAPER_RESTITUTIONS = (0.2, 0.5, 0.8)
PAPER_DROP_HEIGHT = 20.0

MOST_BODIES = 1_000_000
MOST_DROPS = 100_000_000

_SHORTEST_BLOCK = 100
_MOST_BLOCKS = 100
_DROPS_A_CHUNK = 60_000
_MOST_BODIES_A_CHUNK = 32


class DatasetError(PoseStatsError):
    """A dataset that cannot be read, or that is in the way of another one."""


@dataclass(frozen=True)
class DatasetSpec:
    """Everything that a dataset's numbers depend on, besides the program.

    Attributes
    ----------
    bodies : int
        Random polyhedra, from number 0 of the series on.
    drops : int
        Of each body at each restitution.
    restitutions : tuple of float
        Coefficients of restitution, all different.
    shift : float
        Scale of the centre of mass's shift; see `random_polyhedron`.
    shift_moment : str
        `inertia` or `second`.
    seed : int
        Of the series of bodies and of all drops, 0 to 2^64 - 1.
    drop_height : float
        Height of the centre of mass at release, in the bodies' unit: the largest
        distance of a vertex from the centroid.

    Raises
    ------
    RequestError
        If a value is out of its range.
    """

    bodies: int = PAPER_BODIES
    drops: int = PAPER_DROPS
    restitutions: tuple[float, ...] = PAPER_RESTITUTIONS
    shift: float = 0.0
    shift_moment: str = "inertia"
    seed: int = 1
    drop_height: float = PAPER_DROP_HEIGHT

    @property
    def scene(self) -> str:
        """How high the bodies were released, onto what, and how bouncy, in one
        sentence.
        """
        return describe_scene(self.restitutions, self.drop_height)

    def __post_init__(self) -> None:
        _check_count("bodies", self.bodies, MOST_BODIES)
        _check_count("drops", self.drops, MOST_DROPS)
        check_shift(self.shift, self.shift_moment)
        if not _is_whole(self.seed) or not 0 <= self.seed < 2**64:
            raise RequestError(
                "a seed from 0 to 2^64 - 1", f"{self.seed!r}", "1 is the default"
            )
        for restitution in self.restitutions:
            DropScene(restitution, self.drop_height, 0.0, 0)
        if self.drop_height is None:
            raise RequestError(
                "a drop height", "none", f"the paper has {PAPER_DROP_HEIGHT:g}"
            )
        told_apart = {_billionths(restitution) for restitution in self.restitutions}
        if not self.restitutions or len(told_apart) < len(self.restitutions):
            raise RequestError(
                "different restitutions, one at least",
                f"{self.restitutions}",
                "the paper has 0.2, 0.5 and 0.8",
            )
        # 1 and 1.0 are the same number: equal datasets are to be equal bytes.
        for name in ("shift", "drop_height"):
            object.__setattr__(self, name, float(getattr(self, name)))
        object.__setattr__(self, "restitutions", tuple(map(float, self.restitutions)))

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> DatasetSpec:
        """Read what `as_dict` made."""
        return cls(**{**values, "restitutions": tuple(values["restitutions"])})

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {**asdict(self), "restitutions": list(self.restitutions)}

    @property
    def block(self) -> int:
        """Drops counted together: 100, or more where that would make over 100
        blocks.
        """
        return max(_SHORTEST_BLOCK, -(-self.drops // _MOST_BLOCKS))

    @property
    def block_ends(self) -> list[int]:
        """Number of drops at the end of each block; the last one may be shorter."""
        return [*range(self.block, self.drops, self.block), self.drops]

    @property
    def chunks(self) -> list[tuple[int, int]]:
        """First body and number of bodies of each piece of work."""
        size = math.ceil(_DROPS_A_CHUNK / (self.drops * len(self.restitutions)))
        size = min(size, _MOST_BODIES_A_CHUNK)
        return [
            (first, min(size, self.bodies - first))
            for first in range(0, self.bodies, size)
        ]

    def drop_seed(self, body: int, restitution: float, run: int = 0) -> int:
        """Seed of one body's drops at one restitution; independent of all the others.

        Run 0 is the dataset's own.
        """
        entropy = (self.seed, body, _billionths(restitution), *((run,) if run else ()))
        words = np.random.SeedSequence(entropy).generate_state(1, np.uint64)
        return int(words[0])


def _check_count(name: str, value: int, limit: int) -> None:
    if not _is_whole(value) or not 1 <= value <= limit:
        raise RequestError(
            f"1 to {limit} {name}",
            f"{value!r}",
            f"the paper has {PAPER_BODIES} bodies and {PAPER_DROPS} drops",
        )


def _is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _billionths(restitution: float) -> int:
    """A restitution as a whole number, for the seeds of its drops."""
    return round(restitution * 1e9)
