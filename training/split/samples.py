"""Counted drops of the bodies that the split estimator is fitted to and judged by."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats import simulate
from ros_pose_stats.resting.poses import resting_poses
from ros_pose_stats.whole_files import write_whole
from training.families import FAMILIES, family_part, family_tolerance

Index = NDArray[np.int64]

FILE = Path(__file__).resolve().parent / "samples.npz"

FIT_SEED, JUDGE_SEED = 11, 2
"""Seeds of the series of bodies for the fit, and of those for the judgement."""

USUAL = (0.2, 0.5, 0.8)
FIT_DROPS, JUDGE_DROPS, LOW_DROPS = 300, 1000, 500
HIGHEST_RESTITUTION, HIGHEST_DROP = 0.95, 100.0
LOW = 2.0
"""Drop height, in radii, at which the bodies are judged besides 20."""

BODIES: dict[str, tuple[int, int]] = {
    "polyhedra 0": (600, 0), "polyhedra 0.25": (2000, 100), "polyhedra 0.65 second": (600, 0),
    "polyhedra 1": (600, 0), "prisms": (800, 100), "plates": (800, 100), "ellipsoids": (500, 60),
    "machined": (1000, 100), "rounds": (600, 60), "cornered": (700, 60), "weighted": (900, 60),
    "fine rounds": (600, 60), "lumps": (600, 60), "fine ellipsoids": (0, 60)}
"""Numbers of bodies of each family for the fit, and for the judgement."""


class Sample(NamedTuple):
    """One body in one scene.

    Attributes
    ----------
    family : str
    seed, number : int
        Of the body, as `family_part` takes them.
    restitution, height : float
        Height in radii.
    count : (P,) array of int
        Drops that came to rest in each pose, by `index`.
    """

    family: str
    seed: int
    number: int
    restitution: float
    height: float
    count: Index


def drop_body(family: str, seed: int, number: int) -> list[Sample]:
    """Drop one body: in random scenes for the fit, in usual ones for the judgement."""
    draw = np.random.default_rng((seed, number, 991))
    part, tolerance = family_part(family, seed, number), family_tolerance(family)
    radius = resting_poses(part, tolerance, round_sides=0).body.radius
    found = []
    for restitution, height, drops in _scenes(seed, draw):
        counted = simulate(part, drops, restitution, int(draw.integers(1 << 62)),
                           height * radius, workers=1, cluster_tolerance=tolerance, round_sides=0)
        count = np.zeros(len(counted.poses), dtype=np.int64)
        for pose in counted.poses:
            count[pose.index] = pose.count
        found.append(Sample(family, seed, number, restitution, height, count))
    return found


def _scenes(seed: int, draw: np.random.Generator) -> list[tuple[float, float, int]]:
    if seed == JUDGE_SEED:
        return [(rho, height, drops) for height, drops in ((20.0, JUDGE_DROPS), (LOW, LOW_DROPS))
                for rho in USUAL]
    usual = [(rho, 20.0, FIT_DROPS) for rho in USUAL]
    return usual + [(float(draw.uniform(0.0, HIGHEST_RESTITUTION)),
                     math.exp(draw.uniform(0.0, math.log(HIGHEST_DROP))), FIT_DROPS)
                    for _ in range(3)]


def drop_all(workers: int, on_progress: Callable[[int, int], object]) -> list[Sample]:
    """Drop all bodies; takes an hour or two."""
    wanted = [(family, seed, number) for family, bodies in BODIES.items()
              for seed, many in zip((FIT_SEED, JUDGE_SEED), bodies, strict=True)
              for number in range(many)]
    found: list[Sample] = []
    with ThreadPoolExecutor(workers) as pool:
        for done, samples in enumerate(pool.map(lambda one: drop_body(*one), wanted), 1):
            found += samples
            on_progress(done, len(wanted))
    return found


def write_samples(samples: Iterable[Sample], file: Path = FILE) -> None:
    """Write samples, whole or not at all."""
    rows = list(samples)
    columns = {
        "family": np.array([FAMILIES.index(row.family) for row in rows], np.uint8),
        "seed": np.array([row.seed for row in rows], np.uint8),
        "number": np.array([row.number for row in rows], np.uint16),
        "restitution": np.array([row.restitution for row in rows]),
        "height": np.array([row.height for row in rows]),
        "poses": np.array([row.count.size for row in rows], np.uint16),
        "count": np.concatenate([row.count for row in rows]).astype(np.uint16)}
    # The array names are ours; none is that of an argument of savez.
    write_whole(file.parent, lambda folder: np.savez_compressed(
        folder / file.name, **columns))  # type: ignore[arg-type]


def read_samples(file: Path = FILE) -> list[Sample]:
    """Read samples in the order of the file, where all scenes of a body follow each other."""
    with np.load(file) as kept:
        columns = {name: kept[name] for name in kept.files}
    counts = np.split(columns["count"].astype(np.int64), np.cumsum(columns["poses"])[:-1])
    return [Sample(FAMILIES[family], int(seed), int(number), float(restitution), float(height),
                   count)
            for family, seed, number, restitution, height, count in zip(
                columns["family"], columns["seed"], columns["number"], columns["restitution"],
                columns["height"], counts, strict=True)]
