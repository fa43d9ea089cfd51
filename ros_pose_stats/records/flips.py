"""Where a kicked part comes to rest: pose to pose."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .statistics import StablePose

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FlipStatistics:
    """The transition matrix of a kick, counted.

    Attributes
    ----------
    part_id, part_digest : str
    radius : float
        Largest distance from the centre of mass to a vertex, metres.
    restitution : float
    kick_height : float
        Energy of the kick over the weight, metres.
    cluster_tolerance : float
    round_sides : int
    poses : tuple of StablePose
        All K of them by `index`, without probabilities.
    counts : (K, K) array of int
        Row i: flips out of pose i, by the pose in which they ended.
    unsettled : (K,) array of int
        Flips out of each pose that were given up.
    transition : (K, K) array
        Probability of pose j after a kick in pose i; a row sums to 1, or is NaN where nothing
        has settled.
    standard_error : (K, K) array
        Of `transition`; NaN where nothing has settled.
    seed : int
    seconds : float
    warnings : tuple of str
    version : str
    """

    part_id: str
    part_digest: str
    radius: float
    restitution: float
    kick_height: float
    cluster_tolerance: float
    round_sides: int
    poses: tuple[StablePose, ...]
    counts: NDArray[np.int64]
    unsettled: NDArray[np.int64]
    transition: Array
    standard_error: Array
    seed: int
    seconds: float
    warnings: tuple[str, ...]
    version: str

    @property
    def flips(self) -> int:
        """All of them, also those that were given up."""
        return int(self.counts.sum() + self.unsettled.sum())

    def as_dict(self) -> dict[str, Any]:
        """The flips as plain values, in the words of the JSON contract."""
        plain = ("part_id", "part_digest", "radius", "restitution", "kick_height",
                 "cluster_tolerance", "round_sides", "flips", "seed", "seconds", "version")
        entry: dict[str, Any] = {name: getattr(self, name) for name in plain}
        entry["warnings"] = list(self.warnings)
        entry["counts"], entry["unsettled"] = self.counts.tolist(), self.unsettled.tolist()
        for name in ("transition", "standard_error"):
            entry[name] = [[value if math.isfinite(value) else None for value in row]
                           for row in getattr(self, name).tolist()]
        return entry
