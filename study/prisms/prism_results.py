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

"""Results on square prisms: as records, for JSON, as a table and as Fig. 5."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lab.bodies.dice import SOURCE
from lab.frame.documents import markdown_table, plain, points
from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.records import Array
from ros_pose_stats.core.records.scene import describe_scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
        Best first.
    sampling_noise : float
        Root mean square binomial error of the dice, below which no method can be told
        apart.
    drops, dice_drops, seed : int
        As requested.
    release_radii : float
        Height of the centre of mass at release, in radii of the prism.
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
    simulated: dict[float, tuple[SidesPoint, ...]],
) -> list[dict[str, Any]]:
    """A list, since the keys of a JSON object are no numbers."""
    return [
        {"restitution": restitution, "points": plain(series)}
        for restitution, series in simulated.items()
    ]


SHOWN = ("combined", "eae")
"""Estimators beside the dice: the paper's best on its data, and its best on prisms."""


def prisms_text(results: PrismResults) -> str:
    """Tables of how far each method is from the dice, and of the dice themselves."""
    misfits = [
        (misfit.title, points(misfit.rms, 2), points(misfit.standard_error, 2))
        for misfit in results.misfits
    ]
    misfits.append(
        ("sampling noise of the dice", points(results.sampling_noise, 2), "")
    )
    simulated = [f"ρ = {restitution:g}" for restitution in results.dice_simulated]
    shown = [ESTIMATORS[name].title for name in SHOWN]
    return "\n\n".join(
        [
            f"Square prisms, {results.scene}: probability of the four sides together "
            f"in percent (section 5.B, Fig. 5). Dice: {SOURCE}. Simulation: "
            f"{results.dice_drops} drops for each die and restitution, seed "
            f"{results.seed}.",
            markdown_table(
                ("distance from the 15 dice, points", "rms", "standard error"), misfits
            ),
            markdown_table(
                ("length/width", "rolls", "measured", "95 %", *simulated, *shown),
                _dice_rows(results),
            ),
        ]
    )


def _dice_rows(results: PrismResults) -> Iterator[Sequence[str]]:
    """A row a die: what was rolled, simulated and estimated."""
    for row, die in enumerate(results.dice):
        shares = [
            *(series[row].probability for series in results.dice_simulated.values()),
            *(float(results.dice_estimated[name][row]) for name in SHOWN),
        ]
        yield (
            f"{die.ratio:.2f}",
            f"{die.trials}",
            points(die.probability, 2),
            f"{points(die.low, 2)} to {points(die.high, 2)}",
            *(points(share, 2) for share in shares),
        )


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
        (f"simulation, restitution {restitution:g}", _rows(series))
        for restitution, series in results.simulated.items()
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


def _rows(series: tuple[SidesPoint, ...]) -> Array:
    return np.array([point[:4] for point in series]).reshape(-1, 4)
