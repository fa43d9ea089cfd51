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

"""Fits of plates, judged by the parts that they did not see: rolled dice, and simulated
plates.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from lab.bodies.dice import DICE, Die, on_squares, square_prism
from ros_pose_stats.core.estimators.split import split
from ros_pose_stats.core.planning.auto import auto
from ros_pose_stats.core.plates import CountedPart, count_part, fit_plate
from ros_pose_stats.core.plates.likelihood import ROUND_SIDES, ExplainedPart, SceneGrid
from ros_pose_stats.core.records import Array, Index
from ros_pose_stats.core.records.scene import DropScene, Numbering

from .friction import plate_of, read_counts, study_parts

Say = Callable[[str], object]

FITTED = 5
COUNTED = 200
"""Kinds that a plate is fitted to, and counts of each on a simulated plate."""

AS_FILED = Numbering(0.0, 0)  # of dice: every face, as it is

METHODS = (
    "default",
    "default + drops",
    "fit",
    "fit + drops",
    "all others",
    "best scene",
)


@dataclass(frozen=True)
class PlateErrors:
    """How far off the parts are that were not counted on a plate.

    Attributes
    ----------
    plate : str
    errors : dict of str to float
        Root mean square over groups, parts and splits by method, the noise of the
        counts off; of the best scene and of fits to all other parts, over all parts.
    told : float
        Root mean square of `plate_error`.
    default_weight : float
        Mean probability of the default scene.
    """

    plate: str
    errors: dict[str, float]
    told: float
    default_weight: float


@dataclass(frozen=True)
class PlateResults:
    """All plates, the dice first."""

    plates: tuple[PlateErrors, ...]
    splits: int
    seed: int


def plates(
    splits: int = 20, seed: int = 1, *, say: Say = lambda _: None
) -> PlateResults:
    """Fit plates to five kinds of parts and predict the others.

    Parameters
    ----------
    splits : int
        Random choices of the five on each plate, at least 1.
    seed : int
        Of the choices and of which parts are counted, at least 0.
    say : callable
        Told what is done.
    """
    judged = [
        judge_plate(
            "Budden's dice",
            [counted_die(die) for die in DICE],
            10_000,
            splits,
            (seed, 0),
            say,
        )
    ]
    for number, counts in enumerate(read_counts()):
        parts = [
            count_part(part, dict(enumerate(count)))
            for part, count in zip(study_parts(), counts, strict=True)
        ]
        judged.append(
            judge_plate(
                plate_of(number).in_words(),
                parts,
                COUNTED,
                splits,
                (seed, 1 + number),
                say,
            )
        )
    return PlateResults(tuple(judged), splits, seed)


def judge_plate(
    name: str,
    parts: Sequence[CountedPart],
    limit: int,
    splits: int,
    seed: tuple[int, ...],
    say: Say,
) -> PlateErrors:
    """Fit to at most so many counts of each of five parts, and predict the others."""
    squares: dict[str, list[float]] = {method: [] for method in METHODS}
    grid = SceneGrid([part.resting.body.radius for part in parts], ROUND_SIDES[:1])
    explained = [ExplainedPart(part, grid) for part in parts]
    squares["best scene"] = [
        min(
            float(np.mean([part.square_error(scene_index) for part in explained]))
            for scene_index in range(grid.prior.size)
        )
    ]
    by_digest = {part.part.digest: part for part in parts}
    for fitted_part in fit_plate(list(by_digest.values())).parts:
        counted = by_digest[fitted_part.part_digest]
        share = np.bincount(counted.resting.group, fitted_part.left_out).astype(
            np.float64
        )
        squares["all others"].append(_square_error(counted.by_group, share))
    defaults = [shares_in(part, DropScene()) for part in parts]
    plate_errors = []
    weights = []
    for split_number in range(splits):
        random = np.random.default_rng((*seed, split_number))
        order = random.permutation(len(parts))
        chosen = [_draw_counts(parts[k], limit, random) for k in order[:FITTED]]
        fit = fit_plate(chosen)
        height = fit.drop_height[0]
        scene = DropScene(fit.restitution[0], height if height > 0.0 else None)
        plate_errors.append(fit.plate_error)
        weights.append(fit.default_weight)
        for k in order[FITTED:]:
            counts = parts[k].by_group
            for method, shares in (
                ("default", defaults[k]),
                ("default + drops", answer_in(parts[k], DropScene())),
                ("fit", shares_in(parts[k], scene)),
                ("fit + drops", answer_in(parts[k], scene)),
            ):
                squares[method].append(_square_error(counts, shares))
    errors = {
        method: math.sqrt(max(float(np.mean(values)), 0.0))
        for method, values in squares.items()
    }
    say(
        f"{name}: "
        + ", ".join(f"{method} {100.0 * error:.2f}" for method, error in errors.items())
    )
    return PlateErrors(
        name,
        errors,
        float(np.sqrt(np.mean(np.square(plate_errors)))),
        float(np.mean(weights)),
    )


def shares_in(counted: CountedPart, scene: DropScene) -> Array:
    """Shares (G,) of the groups by `split`."""
    share = np.bincount(counted.resting.group, split(counted.resting, scene))
    return share.astype(np.float64)


@cache
def answer_in(counted: CountedPart, scene: DropScene) -> Array:
    """Shares (G,) of the groups by the default answer, drops beside an estimate."""
    statistics = auto(
        counted.part,
        restitution=scene.restitution,
        drop_height=scene.drop_height,
        workers=1,
        **counted.numbering._asdict(),
    )
    share = np.bincount(counted.resting.group, statistics.column("probability"))
    return share.astype(np.float64)


def _draw_counts(
    counted: CountedPart, limit: int, random: np.random.Generator
) -> CountedPart:
    """The same part with at most so many of its counts."""
    count = counted.counts
    sample = random.multivariate_hypergeometric(count, min(limit, int(count.sum())))
    return count_part(
        counted.part,
        dict(enumerate(sample.tolist())),
        **counted.numbering._asdict(),
    )


def _square_error(counts: Index, expected: Array) -> float:
    """Mean square error over groups, the noise of the counts taken off; it may be below
    0.
    """
    observed = counts / counts.sum()
    noise = (observed * (1.0 - observed)).mean() / (counts.sum() - 1)
    return float(np.square(observed - expected).mean() - noise)


def counted_die(die: Die) -> CountedPart:
    """A die with its rolls; on each kind of face they are given to one pose."""
    part = square_prism(die.ratio)
    unknown = count_part(part, {}, **AS_FILED._asdict())
    squares = [pose.index for pose in on_squares(unknown.resting.poses)]
    side = next(
        pose.index for pose in unknown.resting.poses if pose.index not in squares
    )
    return count_part(
        part,
        {squares[0]: die.rolls - die.rolls_on_sides, side: die.rolls_on_sides},
        **AS_FILED._asdict(),
    )
