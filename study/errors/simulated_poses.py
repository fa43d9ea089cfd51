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

"""Counts of the poses of many bodies, with which estimators are compared."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ros_pose_stats.base.errors import RequestError
from ros_pose_stats.core.records import Array, Index


@dataclass(frozen=True, eq=False)
class SimulatedPoses:
    """Simulated probabilities of N poses of many bodies: the set s of the paper,
    section 4.A.

    Parameters
    ----------
    body : (N,) array of int
        Number of the body that a value belongs to, from 0 up. A body may come any
        number of times: for each of its poses, and again for each restitution.
    count : (N,) array of int
        Drops that came to rest in the pose; 0 <= count <= settled.
    settled : (N,) array of int
        Drops of this body at this restitution that came to rest at all, from 2 up.

    Raises
    ------
    RequestError
        If a value has fewer settled drops, so that its noise is not known.
    """

    body: Index
    count: Index
    settled: Index

    def __post_init__(self) -> None:
        fewest = int(self.settled.min())
        if fewest < 2:
            raise RequestError(
                "2 settled drops at least", f"{fewest}", "drop each body more often"
            )

    @property
    def probability(self) -> Array:
        """Simulated probabilities s = count / settled (N,), fractions from 0 to 1."""
        return np.asarray(self.count / self.settled)

    def noise_variance(self) -> Array:
        """Estimate of each value's variance due to the finite number n of drops.

        It is s (1 - s) / (n - 1), whose mean is the variance p (1 - p) / n of
        independent drops; that of the paper's s (1 - s) / n (Eq. 3 with s in place of
        p) is smaller by the factor (n - 1) / n.

        Returns
        -------
        (N,) array
            Squared fractions, from 0 up.
        """
        s = self.probability
        return np.asarray(s * (1.0 - s) / (self.settled - 1))


def pooled(parts: Sequence[SimulatedPoses]) -> SimulatedPoses:
    """The values of several simulations in one row, as the paper pools the
    restitutions.

    Parameters
    ----------
    parts : sequence of SimulatedPoses
        At least one. The same number means the same body in all of them.
    """
    return SimulatedPoses(
        np.concatenate([part.body for part in parts]),
        np.concatenate([part.count for part in parts]),
        np.concatenate([part.settled for part in parts]),
    )
