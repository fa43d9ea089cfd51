"""Fits of plates: to some of the dice, judged by the others, and to simulated plates."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ros_pose_stats.mesh.parts import part_from_mesh
from ros_pose_stats.plates import CountedPart, PlateFit, count_part, fit_plate
from ros_pose_stats.records import Part
from ros_pose_stats.shapes import box, prism
from ros_pose_stats.simulation.simulate import simulate

from ..prisms.dice import DICE, Die
from ..prisms.prism_runs import on_squares, square_prism

Say = Callable[[str], object]

FITTED = 5
"""Dice that a plate is fitted to; the others are predicted."""

PREDICTED_DROPS = 2000
COUNTED = 200
"""Parts of each kind on a simulated plate."""

LOWEST, HIGHEST = 0.02, 0.6
"""Heights of simulated plates, metres; uniform in the logarithm."""

SLOWEST, FASTEST = 0.1, 0.8
"""Their restitutions, uniform."""


@dataclass(frozen=True)
class PrismSplits:
    """Fits to five dice and what they predict of the other ten.

    Attributes
    ----------
    rms : float
        Root mean square error of the predicted frequency of the square faces, over all splits.
    told : float
        Root mean square of `plate_error`.
    ratio : tuple of float
        Told over true error of a split: median and quartiles.
    splits : int
    """

    rms: float
    told: float
    ratio: tuple[float, float, float]
    splits: int


@dataclass(frozen=True)
class SimulatedPlates:
    """How often the 90 % intervals hold the truth.

    Attributes
    ----------
    restitution, drop_height : int
        Plates on which they do.
    plates : int
    told, true : float
        Root mean squares of `plate_error`, and of the error on a part that was not counted.
    """

    restitution: int
    drop_height: int
    plates: int
    told: float
    true: float


@dataclass(frozen=True)
class PlateResults:
    """Both studies; None where one was not asked for."""

    prisms: PrismSplits | None
    simulated: SimulatedPlates | None
    seed: int


def plates(splits: int = 100, simulated: int = 40, seed: int = 1, *,
           workers: int | None = None, say: Say = lambda _: None) -> PlateResults:
    """Fit plates whose truth is known in part or in full.

    Parameters
    ----------
    splits : int
        Random splits of Budden's dice; 0 leaves them out.
    simulated : int
        Plates of a random restitution and height, with 200 counts of each of five parts; 0 leaves
        them out.
    seed : int
        At least 0.
    workers : int, optional
        Threads; default: all cores.
    say : callable
        Told what is done.
    """
    return PlateResults(fit_dice(splits, seed, workers, say) if splits else None,
                        cover(simulated, seed, workers, say) if simulated else None, seed)


def fit_dice(splits: int, seed: int, workers: int | None = None,
             say: Say = lambda _: None) -> PrismSplits:
    """Fit five dice and predict ten, over random splits; see `plates`."""
    counted = [counted_die(die) for die in DICE]
    random = np.random.default_rng((seed, 1))
    true, told = [], []
    for number in range(splits):
        chosen = set(random.choice(len(DICE), FITTED, replace=False).tolist())
        fit = fit_plate([counted[k] for k in sorted(chosen)], seed=_seed(seed, 2, number),
                        workers=workers)
        assert fit is not None  # nothing stops it
        errors = [_dropped(DICE[k], fit, (seed, 3, number, k), workers) - DICE[k].on_squares
                  for k in set(range(len(DICE))) - chosen]
        true.append(math.sqrt(np.mean(np.square(errors))))
        told.append(fit.plate_error)
        say(f"{number + 1} of {splits} splits: true {100.0 * true[-1]:.1f}, told "
            f"{100.0 * told[-1]:.1f} points")
    ratio = np.quantile(np.divide(told, true), (0.5, 0.25, 0.75)).tolist()
    return PrismSplits(float(np.sqrt(np.mean(np.square(true)))),
                       float(np.sqrt(np.mean(np.square(told)))),
                       (ratio[0], ratio[1], ratio[2]), splits)


def counted_die(die: Die) -> CountedPart:
    """A die with its rolls; on each kind of face they are given to one pose."""
    part = square_prism(die.ratio)
    unknown = count_part(part, {}, cluster_tolerance=0.0, round_sides=0)
    squares = [pose.index for pose in on_squares(unknown.resting.poses)]
    side = next(pose.index for pose in unknown.resting.poses if pose.index not in squares)
    return count_part(part, {squares[0]: die.rolls - die.rolls_on_sides,
                             side: die.rolls_on_sides}, cluster_tolerance=0.0, round_sides=0)


def _dropped(die: Die, fit: PlateFit, seed: tuple[int, ...], workers: int | None) -> float:
    """Share of drops in a fitted scene that end on the square faces."""
    found = simulate(square_prism(die.ratio), PREDICTED_DROPS, fit.restitution[0], _seed(*seed),
                     fit.drop_height[0], workers=workers, cluster_tolerance=0.0, round_sides=0)
    return sum(pose.probability for pose in on_squares(found.poses))


def _seed(*place: int) -> int:
    return int(np.random.SeedSequence(place).generate_state(1, np.uint64)[0])


def study_parts() -> list[Part]:
    """Four boxes and a hexagonal prism of 7 to 50 mm."""
    sizes = ((0.02, 0.03, 0.012), (0.01, 0.01, 0.0075), (0.016, 0.022, 0.02),
             (0.03, 0.05, 0.012))
    return [*(part_from_mesh(*box(*size)) for size in sizes),
            part_from_mesh(*prism(6, 0.01, 0.024))]


def cover(number: int, seed: int, workers: int | None = None,
          say: Say = lambda _: None) -> SimulatedPlates:
    """Fit simulated plates and see whether the intervals hold the truth; see `plates`."""
    parts, uncounted = study_parts(), part_from_mesh(*box(0.014, 0.025, 0.018))
    hits, told, true = np.zeros(2, dtype=np.int64), [], []
    for plate in range(number):
        random = np.random.default_rng((seed, 4, plate))
        restitution = float(random.uniform(SLOWEST, FASTEST))
        height = float(np.exp(random.uniform(math.log(LOWEST), math.log(HIGHEST))))
        counted = []
        for k, part in enumerate(parts):
            drops = simulate(part, COUNTED, restitution, _seed(seed, 5, plate, k), height,
                             workers=workers)
            counted.append(count_part(part, {pose.index: pose.count for pose in drops.poses}))
        fit = fit_plate(counted, seed=_seed(seed, 6, plate), workers=workers)
        assert fit is not None  # nothing stops it
        for k, (value, found) in enumerate(((restitution, fit.restitution),
                                            (height, fit.drop_height))):
            hits[k] += found[1] <= value <= found[2]
        told.append(fit.plate_error)
        true.append(_distance(uncounted, (restitution, height),
                              (fit.restitution[0], fit.drop_height[0]), workers))
        say(f"{plate + 1} of {number} simulated plates, {hits[0]} and {hits[1]} intervals hold")
    return SimulatedPlates(int(hits[0]), int(hits[1]), number,
                           float(np.sqrt(np.mean(np.square(told)))),
                           math.sqrt(max(float(np.mean(true)), 0.0)))


def _distance(part: Part, one: tuple[float, float], other: tuple[float, float],
              workers: int | None) -> float:
    """Mean square difference of the groups' shares in two scenes, the noise of drops taken off."""
    shares, noise = [], 0.0
    for number, (restitution, height) in enumerate((one, other)):
        found = simulate(part, PREDICTED_DROPS, restitution, number, height, workers=workers)
        poses = sorted(found.poses, key=lambda pose: pose.index)
        share = np.bincount([pose.group for pose in poses],
                            [pose.probability for pose in poses])
        shares.append(share)
        noise += float((share * (1.0 - share)).mean()) / (PREDICTED_DROPS - 1)
    return float(np.square(shares[0] - shares[1]).mean()) - noise
