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

"""Counts the drops of all bodies, family after family.

What was counted of the families before is there after an interruption.
"""

import math
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import chain
from pathlib import Path

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


def file_of(folder: Path, family: str, seed: int) -> Path:
    """Where the samples of a family are kept until those of all are there."""
    return folder / f"{family}-{seed}.npz".replace(" ", "_")


def series_of(families: Collection[str]) -> list[tuple[str, int, int]]:
    """Family, seed and number of bodies of each series of the work."""
    return [
        (family, seed, count)
        for family, numbers in BODIES.items()
        if family in families
        for seed, count in zip((FIT_SEED, JUDGE_SEED), numbers, strict=True)
        if count
    ]


def count_all(
    folder: Path,
    workers: int,
    on_progress: Callable[[int, int], object],
    families: Collection[str],
) -> None:
    """Count the series that are not in the folder yet; takes an hour or two in all.

    Parameters
    ----------
    folder : Path
        Of a file for each series; they are never counted twice.
    workers : int
        Threads.
    on_progress : callable
        Takes the number of bodies that are there, and of all.
    families : collection of str
        Out of `BODIES`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    series = series_of(families)
    total = sum(count for _, _, count in series)
    counted = 0
    with ThreadPoolExecutor(workers) as pool:
        for family, seed, count in series:
            file = file_of(folder, family, seed)
            if not file.exists():
                bodies = pool.map(partial(drop_body, family, seed), range(count))
                write_samples(chain.from_iterable(bodies), file)
            counted += count
            on_progress(counted, total)


def join_series(
    folder: Path, families: Collection[str], samples: Sequence[Sample]
) -> list[Sample]:
    """Samples of all families: new ones of some, the others as they are.

    Parameters
    ----------
    folder : Path
    families : collection of str
        Of which the folder has all series.
    samples : sequence of Sample
        Of the other families.

    Raises
    ------
    FileNotFoundError
        If a series has not been counted.
    """
    kept_samples = [sample for sample in samples if sample.family not in families]
    counted = [
        sample
        for family, seed, _ in series_of(families)
        for sample in read_samples(file_of(folder, family, seed))
    ]
    order = list(BODIES)
    return sorted(
        kept_samples + counted,
        key=lambda sample: (order.index(sample.family), sample.seed, sample.number),
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
        count = counted.column("count")
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
