"""The benchmark of square prisms as a table for people."""

from __future__ import annotations

from collections.abc import Sequence

from ...estimators import ESTIMATORS
from .dice import SOURCE
from .results import Misfit, PrismResults, SidesPoint

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
    lines = [*_heading(results), "", *_misfits(results), "", *_dice(results), "",
             f"computed in {results.seconds:.1f} s"]
    if results.stopped:
        lines.insert(-1, "stopped before its end: simulations are missing")
    return "\n".join(lines)


def _heading(results: PrismResults) -> list[str]:
    return ["Square prisms: probability of the four sides together (section 5.B, Fig. 5)",
            "",
            f"dice: {SOURCE}",
            f"simulation: {results.dice_drops} drops for each die and restitution, released from "
            f"{results.release_radii:g} radii, seed {results.seed}"]


def _misfits(results: PrismResults) -> list[str]:
    lines = [f"{'distance from the 15 dice':<30} {'rms':>8} {'standard error':>16}",
             f"{'':<30} {'points':>8} {'points':>16}"]
    lines += [_row(misfit) for misfit in results.misfits]
    lines.append(f"{'sampling noise of the dice':<30} {_points(results.sampling_noise):>8}")
    if any(misfit.fitted for misfit in results.misfits):
        lines += ["", "* has a coefficient that was fitted to these dice: no test of it"]
    return lines


def _row(misfit: Misfit) -> str:
    title = f"{misfit.title} *" if misfit.fitted else misfit.title
    return f"{title:<30} {_points(misfit.rms):>8} {_points(misfit.standard_error):>16}"


def _dice(results: PrismResults) -> list[str]:
    simulated = list(results.dice_simulated)
    estimators = [ESTIMATORS[name].title for name in SHOWN]
    spanning = "simulated at restitution".center(10 * len(simulated))
    lines = [f"{'':>12} {'':>6} {'':>9} {'':>15}  {spanning}",
             f"{'length/width':>12} {'rolls':>6} {'measured':>9} {'95 % interval':>15}  "
             + "".join(f"{title:>10}" for title in (*map("{:g}".format, simulated), *estimators)),
             f"{'':>12} {'':>6} {'%':>9} {'%':>15}  "
             + "".join(f"{'%':>10}" for _ in (*simulated, *SHOWN))]
    for place, die in enumerate(results.dice):
        values = [_at(results.dice_simulated[restitution], place) for restitution in simulated]
        values += [_points(float(results.dice_estimated[name][place])) for name in SHOWN]
        interval = f"{_points(die.low)} - {_points(die.high)}"
        lines.append(f"{die.ratio:>12.2f} {die.trials:>6} {_points(die.probability):>9} "
                     f"{interval:>15}  " + "".join(f"{value:>10}" for value in values))
    return [line.rstrip() for line in lines]


def _at(points: Sequence[SidesPoint], place: int) -> str:
    """In percent; a dash where the run was stopped before."""
    return _points(points[place].probability) if place < len(points) else "-"


def _points(fraction: float) -> str:
    """In percent or points."""
    return f"{100.0 * fraction:.2f}"
