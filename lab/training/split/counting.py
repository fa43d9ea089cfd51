"""Counts the drops of all bodies, in parts that an interruption leaves whole.

A part holds a few bodies of one family. Parts come in turn from all families, so that
those that are there at any moment are of every kind.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lab.bodies.families import family_options, family_part, family_poses
from ros_pose_stats import simulate

from .samples import (
    FIT_SEED,
    HEIGHT,
    JUDGE_SEED,
    LOW,
    USUAL,
    Sample,
    read_samples,
    write_samples,
)

BODIES: dict[str, tuple[int, int]] = {
    "polyhedra 0": (230, 0),
    "polyhedra 0.25": (750, 50),
    "polyhedra 0.65 second": (230, 0),
    "polyhedra 1": (230, 0),
    "prisms": (380, 30),
    "near-cubes": (380, 30),
    "plates": (380, 30),
    "sheets": (230, 30),
    "bars": (380, 40),
    "machined": (600, 50),
    "milled": (600, 50),
    "rounds": (380, 30),
    "stepped": (670, 50),
    "hollow": (670, 50),
    "gears": (230, 30),
    "nuts": (200, 20),
    "cap nuts": (70, 10),
    "springs": (12, 4),
    "flat balls": (10, 0),
    "cornered": (380, 30),
    "weighted": (520, 40),
    "lumps": (190, 30),
    "ellipsoids": (230, 30),
    "fine ellipsoids": (0, 30),
}
"""Numbers of bodies of each family for the fit, and for the judgement."""

FIT_DROPS = 200
JUDGE_DROPS = 500
RANDOM_SCENES = {FIT_SEED: 3, JUDGE_SEED: 2}
"""Scenes of a body that are drawn from all restitutions and heights."""

LOWEST_DROP = 0.5
HIGHEST_DROP = 100.0
"""Drop heights, in radii; from the lowest most bodies are released touching the
plate.
"""

BOUNCY = 0.95
HIGHEST_RESTITUTION = 0.99
SELDOM = 0.08
"""Share of random scenes beyond `BOUNCY`, where drops take long."""

SLOW = ("flat balls", "springs")
"""Families that roll for long: some hundred drops a second."""

IN_A_PART = 10


class Block(NamedTuple):
    """Bodies that are counted together."""

    family: str
    seed: int
    first: int
    bodies: int

    def file(self, folder: Path) -> Path:
        """Where its samples are kept until all are there."""
        return folder / f"{self.family}-{self.seed}-{self.first}.npz".replace(" ", "_")


def blocks(families: Collection[str]) -> list[Block]:
    """All parts of the work, in turn from the families, the slow ones last."""
    ranked = [
        (
            (family in SLOW) + first / count,
            Block(family, seed, first, min(IN_A_PART, count - first)),
        )
        for family, numbers in BODIES.items()
        if family in families
        for seed, count in zip((FIT_SEED, JUDGE_SEED), numbers, strict=True)
        for first in range(0, count, IN_A_PART)
    ]
    return [block for _, block in sorted(ranked)]


def count_all(
    folder: Path,
    workers: int,
    on_progress: Callable[[int, int], object],
    families: Collection[str],
) -> None:
    """Count the parts that are not in the folder yet; takes an hour or two in all.

    Parameters
    ----------
    folder : Path
        Of the parts; they are never counted twice.
    workers : int
        Threads.
    on_progress : callable
        Takes the number of parts that are there, and of all.
    families : collection of str
        Out of `BODIES`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    all_blocks = blocks(families)
    missing = [block for block in all_blocks if not block.file(folder).exists()]
    with ThreadPoolExecutor(workers) as pool:
        results = pool.map(lambda block: _count(block, folder), missing)
        for counted, _ in enumerate(results, len(all_blocks) - len(missing) + 1):
            on_progress(counted, len(all_blocks))


def join_parts(
    folder: Path, families: Collection[str], samples: Sequence[Sample]
) -> list[Sample]:
    """Samples of all families: new ones of some, the others as they are.

    Parameters
    ----------
    folder : Path
    families : collection of str
        Of which the folder has all parts.
    samples : sequence of Sample
        Of the other families.

    Raises
    ------
    FileNotFoundError
        If a part has not been counted.
    """
    kept_samples = [sample for sample in samples if sample.family not in families]
    counted = [
        sample
        for block in blocks(families)
        for sample in read_samples(block.file(folder))
    ]
    order = list(BODIES)
    return sorted(
        kept_samples + counted,
        key=lambda sample: (order.index(sample.family), sample.seed, sample.number),
    )


def _count(block: Block, folder: Path) -> None:
    write_samples(
        [
            sample
            for number in range(block.first, block.first + block.bodies)
            for sample in drop_body(block.family, block.seed, number)
        ],
        block.file(folder),
    )


def drop_body(family: str, seed: int, number: int) -> list[Sample]:
    """Drop one body in usual and in random scenes."""
    draw = np.random.default_rng((seed, number, *family.encode()))
    part, (tolerance, sides) = family_part(family, seed, number), family_options(family)
    radius = family_poses(family, part).body.radius
    samples = []
    for restitution, height, drops in _scenes(seed, draw):
        counted = simulate(
            part,
            drops,
            restitution,
            int(draw.integers(1 << 62)),
            height * radius,
            workers=1,
            cluster_tolerance=tolerance,
            round_sides=sides,
        )
        count = np.array([pose.count for pose in counted.by_index.values()])
        samples.append(
            Sample(family, seed, number, restitution, height, counted.unsettled, count)
        )
    return samples


def _scenes(seed: int, draw: np.random.Generator) -> list[tuple[float, float, int]]:
    """Restitution, height in radii and number of drops."""
    drops = JUDGE_DROPS if seed == JUDGE_SEED else FIT_DROPS
    heights = (HEIGHT, LOW) if seed == JUDGE_SEED else (HEIGHT,)
    usual = [(rho, height, drops) for height in heights for rho in USUAL]
    return usual + [(*_random_scene(draw), drops) for _ in range(RANDOM_SCENES[seed])]


def _random_scene(draw: np.random.Generator) -> tuple[float, float]:
    """Any restitution and height, with three digits."""
    bounds = (BOUNCY, HIGHEST_RESTITUTION) if draw.random() < SELDOM else (0.0, BOUNCY)
    height = math.exp(draw.uniform(math.log(LOWEST_DROP), math.log(HIGHEST_DROP)))
    return round(float(draw.uniform(*bounds)), 3), float(f"{height:.3g}")
