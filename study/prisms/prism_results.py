"""Results on square prisms: as records, for JSON, as a table and as Fig. 5."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lab.bodies.dice import SOURCE
from lab.frame.documents import plain
from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.records.scene import describe_scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

LEVEL = 0.95
"""Level of the intervals, as in Fig. 5."""


class SidesPoint(NamedTuple):
    """Share of the trials in which a square prism came to rest on one of its four
    sides.

    Attributes
    ----------
    ratio : float
        Length over width.
    probability : float
        Share of the trials, 0 to 1.
    low, high : float
        Bounds of its 95 % Jeffreys interval.
    trials : int
        Rolls, or drops that settled.
    """

    ratio: float
    probability: float
    low: float
    high: float
    trials: int


class Misfit(NamedTuple):
    """Distance of a method from the dice.

    Attributes
    ----------
    method : str
        Name of an estimator, or `simulation`.
    title : str
        For people.
    restitution : float or None
        None for an estimator.
    rms : float
        Root mean square over the dice of the difference in the probability of the four
        sides.
    standard_error : float
        Of `rms`, from the finite numbers of rolls and drops.
    """

    method: str
    title: str
    restitution: float | None
    rms: float
    standard_error: float


@dataclass(frozen=True, eq=False)
class PrismResults:
    """Fig. 5 in numbers. All probabilities are those of the four sides together, 0 to
    1.

    Attributes
    ----------
    ratios : (k,) array
        Length over width of the estimated curves, rising.
    estimated : dict of str to (k,) array
        By the estimator's name.
    simulated : dict of float to tuple of SidesPoint
        By restitution; by rising ratio.
    dice : tuple of SidesPoint
        As they were rolled, by rising ratio.
    dice_estimated : dict of str to (15,) array
        The estimators at the ratios of the dice.
    dice_simulated : dict of float to tuple of SidesPoint
        The simulation at the ratios of the dice.
    misfits : tuple of Misfit
        Best first. A restitution at which not all dice were simulated is left out.
    sampling_noise : float
        Root mean square binomial error of the dice, below which no method can be told
        apart.
    drops, dice_drops, seed : int
        As requested.
    release_radii : float
        Height of the centre of mass at release, in radii of the prism.
    stopped : bool
        Whether simulations are missing because the run was stopped.
    seconds : float
        Time of the run.
    """

    ratios: Array
    estimated: dict[str, Array]
    simulated: dict[float, tuple[SidesPoint, ...]]
    dice: tuple[SidesPoint, ...]
    dice_estimated: dict[str, Array]
    dice_simulated: dict[float, tuple[SidesPoint, ...]]
    misfits: tuple[Misfit, ...]
    sampling_noise: float
    drops: int
    dice_drops: int
    seed: int
    release_radii: float
    stopped: bool
    seconds: float

    @property
    def scene(self) -> str:
        """How high the prisms were released, onto what, and how bouncy, in one
        sentence.
        """
        return describe_scene(tuple(self.simulated), None)

    def as_dict(self) -> dict[str, Any]:
        """The results as plain values that JSON can hold; every number is finite."""
        return {
            "level": LEVEL,
            "scene": self.scene,
            **plain(self),
            "simulated": _by_restitution(self.simulated),
            "dice_simulated": _by_restitution(self.dice_simulated),
        }


def _by_restitution(
    points: dict[float, tuple[SidesPoint, ...]],
) -> list[dict[str, Any]]:
    """A list, since the keys of a JSON object are no numbers."""
    return [
        {"restitution": restitution, "points": plain(series)}
        for restitution, series in points.items()
    ]


SHOWN = ("combined", "eae")
"""Estimators beside the dice: the paper's best on its data, and its best on prisms."""


def prisms_text(results: PrismResults) -> str:
    """Tables of how far each method is from the dice, and of the dice themselves.

    Parameters
    ----------
    results : PrismResults

    Returns
    -------
    str
        Lines of at most 100 characters, without an end of line at the end.
    """
    lines = [
        *_heading(results),
        "",
        *_misfits(results),
        "",
        *_dice(results),
        "",
        f"computed in {results.seconds:.1f} s",
    ]
    if results.stopped:
        lines.insert(-1, "stopped before its end: simulations are missing")
    return "\n".join(lines)


def _heading(results: PrismResults) -> list[str]:
    return [
        f"Square prisms, {results.scene}",
        "probability of the four sides together (section 5.B, Fig. 5)",
        "",
        f"dice: {SOURCE}",
        f"simulation: {results.dice_drops} drops for each die and restitution, seed "
        f"{results.seed}",
    ]


def _misfits(results: PrismResults) -> list[str]:
    lines = [
        f"{'distance from the 15 dice':<30} {'rms':>8} {'standard error':>16}",
        f"{'':<30} {'points':>8} {'points':>16}",
    ]
    lines += [_row(misfit) for misfit in results.misfits]
    lines.append(
        f"{'sampling noise of the dice':<30} {_points(results.sampling_noise):>8}"
    )
    return lines


def _row(misfit: Misfit) -> str:
    error = _points(misfit.standard_error)
    return f"{misfit.title:<30} {_points(misfit.rms):>8} {error:>16}"


def _dice(results: PrismResults) -> list[str]:
    simulated = list(results.dice_simulated)
    estimators = [ESTIMATORS[name].title for name in SHOWN]
    spanning = "simulated at restitution".center(10 * len(simulated))
    lines = [
        f"{'':>12} {'':>6} {'':>9} {'':>15}  {spanning}",
        f"{'length/width':>12} {'rolls':>6} {'measured':>9} {'95 % interval':>15}  "
        + "".join(
            f"{title:>10}" for title in (*map("{:g}".format, simulated), *estimators)
        ),
        f"{'':>12} {'':>6} {'%':>9} {'%':>15}  "
        + "".join(f"{'%':>10}" for _ in (*simulated, *SHOWN)),
    ]
    for row, die in enumerate(results.dice):
        values = [
            _share_at(results.dice_simulated[restitution], row)
            for restitution in simulated
        ]
        values += [_points(float(results.dice_estimated[name][row])) for name in SHOWN]
        interval = f"{_points(die.low)} - {_points(die.high)}"
        lines.append(
            f"{die.ratio:>12.2f} {die.trials:>6} {_points(die.probability):>9} "
            f"{interval:>15}  " + "".join(f"{value:>10}" for value in values)
        )
    return [line.rstrip() for line in lines]


def _share_at(points: Sequence[SidesPoint], row: int) -> str:
    """A share in percent; a dash where the run was stopped before."""
    return _points(points[row].probability) if row < len(points) else "-"


def _points(fraction: float) -> str:
    """A fraction in percent or points."""
    return f"{100.0 * fraction:.2f}"


EXISTING = ("area", "csae", "adre", "qse", "pqse")
"""Estimators that the paper found in the literature (Table I)."""


def draw_prisms(results: PrismResults) -> Figure:
    """Fig. 5: existing estimators on the left, new ones on the right, points in both.

    Parameters
    ----------
    results : PrismResults

    Returns
    -------
    Figure
        To be written with `output.save_figure`.
    """
    from ..figures.prisms import prisms_figure

    new = [name for name in results.estimated if name not in EXISTING]
    simulated = [
        (f"simulation, restitution {restitution:g}", _rows(points))
        for restitution, points in results.simulated.items()
    ]
    return prisms_figure(
        results.ratios,
        [
            ("existing estimators", _curves(results, EXISTING)),
            ("new estimators", _curves(results, new)),
        ],
        simulated,
        _rows(results.dice),
        "Square prisms coming to rest on a side",
        f"Bars: {100.0 * LEVEL:g} % intervals. {results.drops} drops a diamond; the "
        "simulations of one prism stand side by side, the middle one at its length / "
        "width.",
    )


def _curves(results: PrismResults, names: Sequence[str]) -> list[tuple[str, Array]]:
    return [(ESTIMATORS[name].title, results.estimated[name]) for name in names]


def _rows(points: tuple[SidesPoint, ...]) -> Array:
    return np.array([point[:4] for point in points]).reshape(-1, 4)
