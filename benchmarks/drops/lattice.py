"""How much surer evenly spread starts are than random ones."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from ..results import Row, Section
from .dropper import RESTITUTIONS, Dropper

Array = NDArray[np.float64]

HEIGHTS = (1.5, 5.0, 20.0)
"""Of release, in radii."""

TIMED = (
    "Variance of the pose probabilities from n drops of a lattice over that from n independent "
    "random starts: the mean square error over {} seeds, summed over the poses, over "
    "p (1 - p) / n, averaged over {} bodies ({} vertices, cluster tolerance 0). p is the mean of "
    "all seeds. Below 1 a lattice needs that many times fewer drops; errors are standard errors "
    "from the scatter between the seeds. Not times.")


def lattice(droppers: Sequence[Dropper], seeds: int, prefixes: Sequence[int]) -> Section:
    """A row for each restitution and height of release, a column for each n of `prefixes`."""
    rows = []
    for restitution in RESTITUTIONS:
        for height in HEIGHTS:
            found = [_ratios(dropper, restitution, height, seeds, prefixes)
                     for dropper in droppers]
            ratio = np.mean([one for one, _ in found], axis=0).tolist()
            error = (np.sqrt(np.sum([two**2 for _, two in found], axis=0))
                     / len(droppers)).tolist()
            cells = {}
            for n, value, sure in zip(prefixes, ratio, error, strict=True):
                cells |= {f"n = {n}": value, f"error, n = {n}": sure}
            rows.append(Row(f"restitution {restitution}, released {height:g} radii up", cells))
    corners = " and ".join(str(dropper.vertices) for dropper in droppers)
    return Section("drop_lattice", "A lattice of starts against random ones",
                   TIMED.format(seeds, len(droppers), corners), tuple(rows))


def _ratios(dropper: Dropper, restitution: float, height: float, seeds: int,
            prefixes: Sequence[int]) -> tuple[Array, Array]:
    """Variance over that of random starts, and its error, for each prefix."""
    rules = dropper.rules(restitution, height)

    def poses(seed: int) -> NDArray[np.int64]:
        return dropper.drop(rules, seed, max(prefixes), "lattice").pose

    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        pose = np.array(list(pool.map(poses, range(seeds))))
    hit = pose[:, :, None] == np.arange(dropper.poses)
    p = hit.mean(axis=(0, 1))
    found = []
    for n in prefixes:
        share = hit[:, :n].mean(axis=1)
        square = ((share - share.mean(axis=0)) ** 2).sum(axis=1) * seeds / (seeds - 1)
        ratio = square / ((p * (1.0 - p)).sum() / n)
        found.append((ratio.mean(), ratio.std(ddof=1) / seeds**0.5))
    values = np.array(found)
    return values[:, 0], values[:, 1]
