"""The documents of the stability study: a page, a figure for each walk, and the numbers."""

from __future__ import annotations

from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from lab.frame.documents import markdown_table, points, write_page
from ros_pose_stats.base.text import listed
from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.records.scene import DEFAULT_RESTITUTION, describe_scene

from ..figures.stability import WalkCurve, WalkPanel, reliability_figure, walk_figure
from ..paper import ERRORS
from .jumps import spread
from .lessons import LESSONS
from .walk_runs import COMBINED_DROPS, LEVEL, Curve, StabilityResults, WalkResults

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = "stability.md"


def write_stability(found: StabilityResults, folder: Path) -> list[Path]:
    """Write `measured/stability.md`, its figures and numbers.

    Parameters
    ----------
    found : StabilityResults
    folder : Path
        Created where it does not exist; other files in it stay.

    Returns
    -------
    list of Path
        What was written.
    """
    figures = {f"stability_{one.walk.name}": draw_walk(one) for one in found.walks}
    return write_page(
        folder,
        PAGE,
        stability_page(found),
        {**figures, "stability_reliability": draw_reliability(found)},
        {"stability": as_dict(found)},
    )


def as_dict(found: StabilityResults) -> dict[str, Any]:
    """Plain values for JSON."""
    return {
        "scene": SCENE,
        "walks": [_walk(one) for one in found.walks],
        "reliability": {
            name: [one._asdict() for one in bins]
            for name, bins in found.reliability.items()
        },
    }


def _walk(one: WalkResults) -> dict[str, Any]:
    return {
        "name": one.walk.name,
        "title": one.walk.title,
        "parameter": one.walk.parameter,
        "logarithmic": one.walk.logarithmic,
        "watched": one.walk.quantity,
        "cluster_tolerance": one.walk.cluster_tolerance,
        "values": one.values.tolist(),
        "poses": one.poses.tolist(),
        "methods": [_method(one, curve) for curve in one.curves],
        "simulation": {
            "probability": one.simulated.values.tolist(),
            "low": one.simulated.low.tolist(),
            "high": one.simulated.high.tolist(),
            "settled": one.simulated.settled.tolist(),
        },
    }


def _method(found: WalkResults, one: Curve) -> dict[str, Any]:
    return {
        "method": one.method,
        "probability": one.values.tolist(),
        "slope": one.change.slope,
        "slope_at": found.walk.value(one.change.slope_at),
        "jumps": [
            {"at": found.walk.value(jump.place), "size": jump.size}
            for jump in one.change.jumps
        ],
    }


WIDTH = 99

SCENE: Final = f"Unless a walk changes it: {describe_scene(DEFAULT_RESTITUTION, None)}."

INTRODUCTION = """# Where methods fail

Written by `python -m study stability -o docs`; edits here are lost.

{scene}

Each section walks a body, or the scene that it falls into, through one kind of trouble. The figure
shows one probability along the walk by every estimator and by drop simulation; crosses are jumps,
found by halving the step until the change stays. In the tables

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
    parts = [INTRODUCTION.format(scene=SCENE)]
    for one in found.walks:
        name = one.walk.name
        picture = f"![{one.walk.title}](../figures/stability_{name}.png)"
        parts += [
            f"## {one.walk.title}\n",
            f"{picture}\n",
            *wrap(LESSONS[name], WIDTH),
            "",
            walk_text(one),
            "",
        ]
    return "\n".join([*parts, RELIABILITY, reliability_text(found), ""])


def stability_text(found: StabilityResults) -> str:
    """All tables."""
    parts = [f"### {one.walk.title}\n\n{walk_text(one)}" for one in found.walks]
    return "\n\n".join(
        [SCENE, *parts, f"### Expected errors\n\n{reliability_text(found)}"]
    )


def reliability_text(found: StabilityResults) -> str:
    """Table with a row for each method: expected and true error in every bin of parts."""
    bins = len(next(iter(found.reliability.values())))
    head = ["method, expected / true", *(f"bin {k + 1}" for k in range(bins))]
    rows = [
        [
            ESTIMATORS[name].title if name in ESTIMATORS else name,
            *(f"{points(one.expected)} / {points(one.true)}" for one in some),
        ]
        for name, some in found.reliability.items()
    ]
    return markdown_table(head, rows)


def walk_text(found: WalkResults) -> str:
    """A line that says where methods differ most, and a table with a row for each method."""
    curves = {one.method: one.values for one in found.curves}
    place, apart = spread(list(curves.values()))
    at = {name: float(values[place]) for name, values in curves.items()}
    low = min(at, key=at.__getitem__)
    high = max(at, key=at.__getitem__)
    steps = np.abs(np.diff(found.simulated.values))
    noise = _noise(found)
    said = (
        f"Watched: {found.walk.quantity}; {found.poses.min()} to {found.poses.max()} stable "
        f"poses. The methods are farthest apart at {found.values[place]:.3g}: {_title(low)} "
        f"{points(at[low])} %, {_title(high)} {points(at[high])} %, {points(apart)} points. "
        f"The simulation's standard error is at most {points(noise.max(), 2)} points, its "
        f"largest step between neighbouring values {points(steps.max())}."
    )
    head = (
        "method",
        "jumps",
        "largest jump, points",
        "slope, points a per cent",
        "at",
        "off, points",
        "at",
        "beyond noise",
    )
    rows = markdown_table(head, [_row(found, one) for one in found.curves])
    return "\n".join([*wrap(said, WIDTH), "", rows])


def _row(found: WalkResults, one: Curve) -> tuple[str, ...]:
    away = np.abs(one.values - found.simulated.values)
    worst = int(np.argmax(away))
    sizes = [abs(jump.size) for jump in one.change.jumps]
    far = int((away > 4.0 * _noise(found)).sum())
    return (
        _title(one.method),
        str(len(sizes)),
        points(max(sizes)) if sizes else "",
        points(0.01 * one.change.slope, 3),
        f"{found.walk.value(one.change.slope_at):.3g}" if one.change.slope else "",
        points(float(away[worst])),
        f"{found.values[worst]:.3g}",
        f"{far} of {len(found.values)}",
    )


def _noise(found: WalkResults) -> NDArray[np.float64]:
    """Standard error of the simulation at each value, never 0."""
    n = found.simulated.settled
    q = (found.simulated.values * n + 0.5) / (n + 1.0)
    return np.asarray(np.sqrt(q * (1.0 - q) / n))


def _title(name: str) -> str:
    return ESTIMATORS[name].title


PAPER = "the paper's estimators and those before it"


def draw_walk(found: WalkResults) -> Figure:
    """Estimators of the paper on the left, newer ones on the right, the simulation in both."""
    walk = found.walk
    simulated = found.simulated
    paper = [_curve(found, one) for one in found.curves if one.method in ERRORS]
    ours = [_curve(found, one) for one in found.curves if one.method not in ERRORS]
    with_drops = "drops with it" if len(ours) == 1 else "hybrid"
    heading = f"{listed([one.label for one in ours])}, and {with_drops}"
    ours.append(WalkCurve(f"hybrid, {COMBINED_DROPS} drops", found.combined))
    drops = int(simulated.settled.max())
    return walk_figure(
        found.values,
        [WalkPanel(PAPER, paper), WalkPanel(heading, ours, paper, "those on the left")],
        np.array([simulated.values, simulated.low, simulated.high]),
        walk.parameter,
        walk.quantity,
        logarithmic=walk.logarithmic,
        mark=walk.mark,
        title=walk.title,
        note=f"Bars: {100.0 * LEVEL:g} % intervals of {drops} drops.{_tolerance(found)} {SCENE}",
    )


def _tolerance(found: WalkResults) -> str:
    """The cluster tolerance, where the walk does not change it."""
    walk = found.walk
    changed = walk.make(float(found.values[0])).cluster_tolerance is not None
    return "" if changed else f" Cluster tolerance {walk.cluster_tolerance:g}."


def draw_reliability(found: StabilityResults) -> Figure:
    """Expected against true errors, a panel a method."""
    return reliability_figure(
        [
            (
                ESTIMATORS[name].title if name in ESTIMATORS else name,
                np.array([(one.expected, one.true, one.error) for one in bins]),
            )
            for name, bins in found.reliability.items()
        ]
    )


def _curve(found: WalkResults, one: Curve) -> WalkCurve:
    jumps = [(found.walk.value(jump.place), jump.size) for jump in one.change.jumps]
    return WalkCurve(ESTIMATORS[one.method].title, one.values, jumps)
