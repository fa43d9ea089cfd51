"""Counts of the poses of many bodies, with which estimators are compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ros_pose_stats.base.errors import RequestError

Array = NDArray[np.float64]
Index = NDArray[np.int64]


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
        Drops of this body at this restitution that came to rest at all, from 1 up.

    Raises
    ------
    RequestError
        If the three are not equally long rows of whole numbers in their ranges, or
        empty.
    """

    body: Index
    count: Index
    settled: Index

    def __post_init__(self) -> None:
        for name in ("body", "count", "settled"):
            object.__setattr__(self, name, _whole_numbers(name, getattr(self, name)))
        sizes = self.body.size, self.count.size, self.settled.size
        if len(set(sizes)) != 1:
            raise RequestError(
                "as many bodies, counts and settled drops",
                "{}, {} and {}".format(*sizes),
                "give each value all three",
            )
        bad = (self.count > self.settled) | (self.settled < 1)
        if bad.any():
            raise RequestError(
                "counts up to the settled drops, of which there is one at least",
                f"{self.count[bad][0]} of {self.settled[bad][0]}",
                "count the settled drops alone and leave out bodies without any",
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

        Raises
        ------
        RequestError
            If a value has a single settled drop.
        """
        s = self.probability
        if self.settled.min() < 2:
            raise RequestError(
                "2 settled drops at least", "1", "drop each body more often"
            )
        return np.asarray(s * (1.0 - s) / (self.settled - 1))


def pooled(parts: Sequence[SimulatedPoses]) -> SimulatedPoses:
    """The values of several simulations in one row, as the paper pools the
    restitutions.

    Parameters
    ----------
    parts : sequence of SimulatedPoses
        At least one. The same number means the same body in all of them.

    Raises
    ------
    RequestError
        If there is none.
    """
    if not parts:
        raise RequestError(
            "one simulation at least", "none", "give the poses of one restitution"
        )
    return SimulatedPoses(
        np.concatenate([part.body for part in parts]),
        np.concatenate([part.count for part in parts]),
        np.concatenate([part.settled for part in parts]),
    )


def _whole_numbers(name: str, values: ArrayLike) -> Index:
    array = np.asarray(values)
    if (
        array.ndim != 1
        or array.dtype.kind not in "iu"
        or array.size == 0
        or array.min() < 0
    ):
        raise RequestError(
            f"one row of whole numbers from 0 up as the {name} of each value",
            f"shape {array.shape} of {array.dtype}"
            + (f" from {array.min()}" if array.size else ""),
            "give an array (N,) of int",
        )
    return array.astype(np.int64)
