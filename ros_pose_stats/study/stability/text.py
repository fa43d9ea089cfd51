"""The stability study for people: a table for each walk, and the page."""

from __future__ import annotations

from textwrap import wrap

import numpy as np
from numpy.typing import NDArray

from ...estimators.registry import ESTIMATORS
from ..markdown import markdown_table, points
from .jumps import spread
from .lessons import LESSONS
from .run import Curve, StabilityResults, WalkResults

WIDTH = 99

INTRODUCTION = """# Where methods fail

Written by `ros_pose_stats benchmark stability -o docs`; edits here are lost.

Each section walks a body, or the scene that it falls into, through one kind of trouble. The figure
shows one probability along the walk by every estimator and by drop simulation at restitution
0.5 (unless the walk changes it); crosses are jumps, found by halving the step until the change
stays. In the tables

- `jumps` is the number of jumps of at least 0.2 points, and the largest of them,
- `slope` the largest change in points for a relative change of the parameter by one per cent
  (for walks on a linear axis: for a change by 0.01), away from jumps, and where,
- `off` the largest distance from the simulation, in points, and where; `beyond noise` counts the
  values at which it is more than four standard errors of the simulation.
"""


RELIABILITY = """## Expected and true errors

![Expected against true errors, parts in ten bins](../figures/stability_reliability.png)

Every answer carries an `expected_error`. Here the parts of all reference datasets are sorted by
it, for each method by itself, and put in ten bins; the table gives the root mean squares over
each bin of what was expected and of what came true, in points. The last row is a simulation of
100 drops, judged by the 900 others.
"""


def stability_page(found: StabilityResults) -> str:
    """The whole page, Markdown."""
    parts = [INTRODUCTION]
    for one in found.walks:
        name = one.walk.name
        picture = f"![{one.walk.title}](../figures/stability_{name}.png)"
        parts += [f"## {one.walk.title}\n", f"{picture}\n",
                  *wrap(LESSONS[name], WIDTH), "", walk_text(one), ""]
    return "\n".join([*parts, RELIABILITY, reliability_text(found), ""])


def stability_text(found: StabilityResults) -> str:
    """All tables."""
    parts = [f"### {one.walk.title}\n\n{walk_text(one)}" for one in found.walks]
    return "\n\n".join([*parts, f"### Expected errors\n\n{reliability_text(found)}"])


def reliability_text(found: StabilityResults) -> str:
    """A row a method: expected and true error in every bin of parts."""
    bins = len(next(iter(found.reliability.values())))
    head = ["method, expected / true", *(f"bin {k + 1}" for k in range(bins))]
    rows = [[ESTIMATORS[name].title if name in ESTIMATORS else name,
             *(f"{points(one.expected)} / {points(one.true)}" for one in some)]
            for name, some in found.reliability.items()]
    return markdown_table(head, rows)


def walk_text(found: WalkResults) -> str:
    """Where methods part company, a line, and a table with a row a method."""
    curves = {one.method: one.values for one in found.curves}
    place, apart = spread(list(curves.values()))
    at = {name: float(values[place]) for name, values in curves.items()}
    low, high = min(at, key=at.__getitem__), max(at, key=at.__getitem__)
    steps = np.abs(np.diff(found.simulated.values))
    noise = _noise(found)
    said = (f"Watched: {found.walk.quantity}; {found.poses.min()} to {found.poses.max()} stable "
            f"poses. The methods are farthest apart at {found.values[place]:.3g}: {_title(low)} "
            f"{points(at[low])} %, {_title(high)} {points(at[high])} %, {points(apart)} points. "
            f"The simulation's standard error is at most {points(noise.max(), 2)} points, its "
            f"largest step between neighbouring values {points(steps.max())}.")
    head = ("method", "jumps", "largest jump, points", "slope, points a per cent", "at",
            "off, points", "at", "beyond noise")
    rows = markdown_table(head, [_row(found, one) for one in found.curves])
    return "\n".join([*wrap(said, WIDTH), "", rows])


def _row(found: WalkResults, one: Curve) -> tuple[str, ...]:
    away = np.abs(one.values - found.simulated.values)
    worst = int(np.argmax(away))
    sizes = [abs(jump.size) for jump in one.change.jumps]
    far = int((away > 4.0 * _noise(found)).sum())
    return (_title(one.method), str(len(sizes)), points(max(sizes)) if sizes else "",
            points(0.01 * one.change.slope, 3),
            f"{found.walk.value(one.change.slope_at):.3g}" if one.change.slope else "",
            points(float(away[worst])), f"{found.values[worst]:.3g}",
            f"{far} of {len(found.values)}")


def _noise(found: WalkResults) -> NDArray[np.float64]:
    """Standard error of the simulation at each value, never 0."""
    n = found.simulated.settled
    q = (found.simulated.values * n + 0.5) / (n + 1.0)
    return np.asarray(np.sqrt(q * (1.0 - q) / n))


def _title(name: str) -> str:
    return ESTIMATORS[name].title
