"""Fig. 5 from the results."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...estimators import ESTIMATORS
from .results import LEVEL, Array, PrismResults, SidesPoint

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
        To be written with `plots.files.save_figure`.
    """
    from ...plots.study.prisms import prisms_figure  # matplotlib is loaded only where it draws

    new = [name for name in results.estimated if name not in EXISTING]
    simulated = [(f"simulation, restitution {restitution:g}", _rows(points))
                 for restitution, points in results.simulated.items()]
    return prisms_figure(
        results.ratios,
        [("existing estimators", _curves(results, EXISTING)),
         ("new estimators", _curves(results, new))],
        simulated, _rows(results.dice),
        "Square prisms coming to rest on a side",
        f"Bars: {100.0 * LEVEL:g} % intervals. {results.drops} drops a diamond; the simulations "
        "of one prism stand side by side, the middle one at its length / width.")


def _curves(results: PrismResults, names: Sequence[str]) -> list[tuple[str, Array]]:
    fitted = {misfit.method for misfit in results.misfits if misfit.fitted}
    return [(f"{ESTIMATORS[name].title} (fitted to the dice)" if name in fitted
             else ESTIMATORS[name].title, results.estimated[name]) for name in names]


def _rows(points: tuple[SidesPoint, ...]) -> Array:
    return np.array([point[:4] for point in points]).reshape(-1, 4)
