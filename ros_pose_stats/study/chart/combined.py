"""Points of the chart for the estimate and some drops together."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...planning.hybrid import hybrid
from ...plots.study.speed_accuracy import ChartPoint
from ...records import PoseStatistics
from ..errors.partition import accuracy
from ..errors.simulated_poses import pooled
from .clock import medians
from .methods import Effort, point, some
from .sizes import Mesh, Size

Array = NDArray[np.float64]

SERIES = "hybrid"
SEED = 31
"""Of the drops, with the body's number; the reference has others."""


def combined_points(size: Size, effort: Effort) -> Iterator[ChartPoint]:
    """One point a number of drops: measured against the reference on all bodies.

    The drops of the reference are other ones, so its noise can be taken off.
    """
    every = pooled(list(size.simulated.values()))
    for drops in effort.combined:
        took = medians([{"": partial(_hybrid, mesh, drops, restitution, size.height, 1)}
                        for restitution in size.simulated
                        for mesh in some(size.meshes, effort.timed(drops))])
        told = [_told(mesh, drops, restitution, size.height, number)
                for restitution in size.simulated for number, mesh in enumerate(size.meshes)]
        yield point(f"n = {drops:,}".replace(",", " "), "hybrid", took[""],
                    accuracy(np.concatenate(told), every), SERIES)


def _told(mesh: Mesh, drops: int, restitution: float, height: float | None,
          number: int) -> Array:
    """Probabilities (P,) by `index`."""
    seed = np.random.SeedSequence((SEED, number, round(restitution * 1e9)))
    found = _hybrid(mesh, drops, restitution, height, int(seed.generate_state(1, np.uint64)[0]))
    return np.array([pose.probability for pose in sorted(found.poses, key=lambda one: one.index)])


def _hybrid(mesh: Mesh, drops: int, restitution: float, height: float | None,
            seed: int) -> PoseStatistics:
    return hybrid(mesh.part(), drops, restitution, seed, height, workers=1, cluster_tolerance=0.0)
