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

"""Square prisms by every estimator and by drop simulation."""

import time
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lab.bodies.dice import DICE, on_squares, square_prism
from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.records import Array, DropScene
from ros_pose_stats.core.records.scene import DEFAULT_DROP_RADII
from ros_pose_stats.core.resting.poses import resting_poses
from ros_pose_stats.core.simulation.request import drop_request
from ros_pose_stats.core.simulation.simulate import simulate
from ros_pose_stats.core.statistics.errors import jeffreys_interval

from .dice import root_mean_square, sampling_noise, standard_error
from .prism_results import LEVEL, Misfit, PrismResults, SidesPoint

Points = dict[float, tuple[SidesPoint, ...]]

RESTITUTIONS = (0.2, 0.5, 0.8)
SHORTEST = 0.3
LONGEST = 3.0
"""Length over width."""
CURVE_RATIOS = 121
DROPPED_RATIOS = 15
DROPS = 1000
DICE_DROPS = 2000
DEFAULT_SEED = 1
OF_CURVE, OF_DICE, OF_ERRORS = range(3)
"""Streams of random numbers."""


def prisms(
    drops: int = DROPS,
    dice_drops: int = DICE_DROPS,
    seed: int = DEFAULT_SEED,
    *,
    on_progress: Callable[[int, int], object] = lambda *_: None,
) -> PrismResults:
    """Compare estimators, simulation and rolled dice on square prisms (section 5.B,
    Fig. 5).

    Square prisms of length over width 0.3 to 3 go through every registered estimator
    and are dropped from 20 radii at restitution 0.2, 0.5 and 0.8. The same is done for
    prisms as long as Budden's dice, to say how far each method is from them.

    Parameters
    ----------
    drops : int
        For each of 15 ratios and each restitution, at least 1.
    dice_drops : int
        For each of the 15 dice and each restitution, at least 1.
    seed : int
        0 to 2^64 - 1. The same seed gives the same numbers.
    on_progress : callable, optional
        Called with the drops done and the drops in all, after each simulation.

    Returns
    -------
    PrismResults

    Raises
    ------
    RequestError
        If a number of drops or the seed are out of their range.
    """
    begin = time.perf_counter()
    for number in (drops, dice_drops):
        drop_request(number, seed, 0.0, None, None)
    curve = np.array(_spread(CURVE_RATIOS))
    of_dice = [die.ratio for die in DICE]
    planned = [
        *_plan(_spread(DROPPED_RATIOS), drops, seed, OF_CURVE),
        *_plan(of_dice, dice_drops, seed, OF_DICE),
    ]
    finished = _run(planned, on_progress)
    dice_estimated = estimated_sides(of_dice)
    dice_simulated = _gathered(finished, OF_DICE)
    return PrismResults(
        ratios=curve,
        estimated=estimated_sides(curve),
        simulated=_gathered(finished, OF_CURVE),
        dice=tuple(counted(die.ratio, die.rolls_on_sides, die.rolls) for die in DICE),
        dice_estimated=dice_estimated,
        dice_simulated=dice_simulated,
        misfits=_misfits(dice_estimated, dice_simulated, seed),
        sampling_noise=sampling_noise(),
        drops=drops,
        dice_drops=dice_drops,
        seed=seed,
        release_radii=DEFAULT_DROP_RADII,
        seconds=time.perf_counter() - begin,
    )


class _Drops(NamedTuple):
    """A simulation of the plan."""

    stream: int
    restitution: float
    ratio: float
    drops: int
    seed: int


def _spread(count: int) -> list[float]:
    """Ratios from the shortest to the longest, evenly spread in their logarithm."""
    ratios: list[float] = np.geomspace(SHORTEST, LONGEST, count).tolist()
    return ratios


def _plan(ratios: Sequence[float], drops: int, seed: int, stream: int) -> list[_Drops]:
    return [
        _Drops(stream, restitution, ratio, drops, _seed(seed, stream, row, number))
        for row, restitution in enumerate(RESTITUTIONS)
        for number, ratio in enumerate(ratios)
    ]


def _seed(seed: int, *words: int) -> int:
    """A seed of its own for each place."""
    return int(np.random.SeedSequence((seed, *words)).generate_state(1, np.uint64)[0])


def _run(
    planned: Sequence[_Drops], on_progress: Callable[[int, int], object]
) -> list[tuple[_Drops, SidesPoint]]:
    finished: list[tuple[_Drops, SidesPoint]] = []
    count = 0
    total = sum(planned_run.drops for planned_run in planned)
    for planned_run in planned:
        point = dropped_sides(
            planned_run.ratio,
            planned_run.restitution,
            planned_run.drops,
            planned_run.seed,
        )
        finished.append((planned_run, point))
        count += planned_run.drops
        on_progress(count, total)
    return finished


def _gathered(finished: Iterable[tuple[_Drops, SidesPoint]], stream: int) -> Points:
    return {
        restitution: tuple(
            point
            for planned_run, point in finished
            if (planned_run.stream, planned_run.restitution) == (stream, restitution)
        )
        for restitution in RESTITUTIONS
    }


def _misfits(
    estimated: dict[str, Array], simulated: Points, seed: int
) -> tuple[Misfit, ...]:
    error_seed = _seed(seed, OF_ERRORS)
    misfits = [
        Misfit(
            name,
            ESTIMATORS[name].title,
            None,
            root_mean_square(sides),
            standard_error(sides, seed=error_seed),
        )
        for name, sides in estimated.items()
    ]
    for restitution, points in simulated.items():
        sides = [point.probability for point in points]
        error = standard_error(
            sides, [point.trials for point in points], seed=error_seed
        )
        misfits.append(
            Misfit(
                "simulation",
                f"simulation, restitution {restitution:g}",
                restitution,
                root_mean_square(sides),
                error,
            )
        )
    # Equal but for rounding (CSAE and QSE): in the order of the registry.
    return tuple(sorted(misfits, key=lambda misfit: round(misfit.rms, 12)))


SCENE = DropScene(cluster_tolerance=0.0, round_sides=0)
"""Scene of estimators that know it: the usual restitution and drop height."""


def estimated_sides(ratios: ArrayLike) -> dict[str, Array]:
    """Probability of the four sides by every estimator, without clusters, in the usual
    scene.

    Parameters
    ----------
    ratios : (k,) array
        Length over width, above 0.

    Returns
    -------
    dict of str to (k,) array
        By the estimator's name, in the registry's order; 0 to 1.
    """
    lengths = np.asarray(ratios, dtype=np.float64)
    shares = {name: np.empty_like(lengths) for name in ESTIMATORS}
    for row, ratio in enumerate(lengths.tolist()):
        resting = resting_poses(square_prism(ratio), 0.0, 0)
        squares = [pose.index for pose in on_squares(resting.poses)]
        for name, estimator in ESTIMATORS.items():
            shares[name][row] = 1.0 - estimator.function(resting, SCENE)[squares].sum()
    return shares


def dropped_sides(
    ratio: float, restitution: float, drops: int, seed: int
) -> SidesPoint:
    """Share of drops from 20 radii that come to rest on a side; those that did not
    settle are left out.
    """
    statistics = simulate(
        square_prism(ratio),
        drops,
        restitution,
        seed,
        cluster_tolerance=0.0,
        round_sides=0,
    )
    settled = statistics.drops - statistics.unsettled
    return counted(
        ratio,
        settled - sum(pose.count for pose in on_squares(statistics.poses)),
        settled,
    )


def counted(ratio: float, sides: int, trials: int) -> SidesPoint:
    """Make a point of a counted share, with its interval."""
    low, high = jeffreys_interval(sides, trials, LEVEL)
    return SidesPoint(ratio, sides / trials, float(low), float(high), trials)
