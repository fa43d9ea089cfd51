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

"""The documents of the stability study: a page, a figure for each walk, and the
numbers.
"""

from __future__ import annotations

from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lab.frame.documents import markdown_table, points, write_page
from ros_pose_stats.base.text import listed
from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.records import Array
from ros_pose_stats.core.records.scene import DEFAULT_RESTITUTION, describe_scene

from ..figures.stability import WalkCurve, WalkPanel, reliability_figure, walk_figure
from ..paper import ERRORS
from .jumps import spread
from .lessons import LESSONS
from .walk_runs import COMBINED_DROPS, LEVEL, Curve, StabilityResults, WalkResults

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = "stability.md"


def write_stability(results: StabilityResults, folder: Path) -> list[Path]:
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
    figures = {
        f"stability_{walk_results.walk.name}": draw_walk(walk_results)
        for walk_results in results.walks
    }
    return write_page(
        folder,
        PAGE,
        stability_page(results),
        {**figures, "stability_reliability": draw_reliability(results)},
        {"stability": as_dict(results)},
    )


def as_dict(results: StabilityResults) -> dict[str, Any]:
    """Plain values for JSON."""
    return {
        "scene": SCENE,
        "walks": [_walk(one) for one in results.walks],
        "reliability": {
            name: [one._asdict() for one in bins]
            for name, bins in results.reliability.items()
        },
    }


def _walk(results: WalkResults) -> dict[str, Any]:
    return {
        "name": results.walk.name,
        "title": results.walk.title,
        "parameter": results.walk.parameter,
        "logarithmic": results.walk.logarithmic,
        "watched": results.walk.quantity,
        "cluster_tolerance": results.walk.cluster_tolerance,
        "values": results.values.tolist(),
        "poses": results.poses.tolist(),
        "methods": [_method(results, curve) for curve in results.curves],
        "simulation": {
            "probability": results.simulated.values.tolist(),
            "low": results.simulated.low.tolist(),
            "high": results.simulated.high.tolist(),
            "settled": results.simulated.settled.tolist(),
        },
    }


def _method(results: WalkResults, curve: Curve) -> dict[str, Any]:
    return {
        "method": curve.method,
        "probability": curve.values.tolist(),
        "slope": curve.change.slope,
        "slope_at": results.walk.value(curve.change.slope_at),
        "jumps": [
            {"at": results.walk.value(jump.position), "size": jump.size}
            for jump in curve.change.jumps
        ],
    }


WIDTH = 99

SCENE: Final = f"Unless a walk changes it: {describe_scene(DEFAULT_RESTITUTION, None)}."

INTRODUCTION = """# Where methods fail

Written by `python -m study stability -o docs`; edits here are lost.

{scene}

Each section walks a body, or the scene that it falls into, through one kind of trouble.
The figure shows one probability along the walk by every estimator and by drop
simulation; crosses are jumps, found by halving the step until the change stays. In the
tables

- `jumps` is the number of jumps of at least 0.2 points, and the largest of them,
- `slope` the largest change in points for a relative change of the parameter by one per
  cent (for walks on a linear axis: for a change by 0.01), away from jumps, and where,
- `off` the largest distance from the simulation, in points, and where; `beyond noise`
  counts the values at which it is more than four standard errors of the simulation.
"""


RELIABILITY = """## Expected and true errors

![Expected against true errors, parts in ten bins](../figures/stability_reliability.png)

Every answer carries an `expected_error`. Here the parts of all reference datasets are
sorted by it, for each method by itself, and put in ten bins; the table gives the root
mean squares over each bin of what was expected and of what came true, in points. The
last row is a simulation of 100 drops, judged by the 900 others.
"""


def stability_page(results: StabilityResults) -> str:
    """The whole page, Markdown."""
    parts = [INTRODUCTION.format(scene=SCENE)]
    for walk_results in results.walks:
        name = walk_results.walk.name
        picture = f"![{walk_results.walk.title}](../figures/stability_{name}.png)"
        parts += [
            f"## {walk_results.walk.title}\n",
            f"{picture}\n",
            *wrap(LESSONS[name], WIDTH),
            "",
            walk_text(walk_results),
            "",
        ]
    return "\n".join([*parts, RELIABILITY, reliability_text(results), ""])


def stability_text(results: StabilityResults) -> str:
    """All tables."""
    parts = [
        f"### {walk_results.walk.title}\n\n{walk_text(walk_results)}"
        for walk_results in results.walks
    ]
    return "\n\n".join(
        [SCENE, *parts, f"### Expected errors\n\n{reliability_text(results)}"]
    )


def reliability_text(results: StabilityResults) -> str:
    """Table with a row for each method: expected and true error in every bin of
    parts.
    """
    bins = len(next(iter(results.reliability.values())))
    head = ["method, expected / true", *(f"bin {k + 1}" for k in range(bins))]
    rows = [
        [
            ESTIMATORS[name].title if name in ESTIMATORS else name,
            *(
                f"{points(parts.expected)} / {points(parts.true)}"
                for parts in reliability_bins
            ),
        ]
        for name, reliability_bins in results.reliability.items()
    ]
    return markdown_table(head, rows)


def walk_text(results: WalkResults) -> str:
    """A line that says where methods differ most, and a table with a row for each
    method.
    """
    curves = {curve.method: curve.values for curve in results.curves}
    row, distance = spread(list(curves.values()))
    shares = {name: float(values[row]) for name, values in curves.items()}
    low = min(shares, key=shares.__getitem__)
    high = max(shares, key=shares.__getitem__)
    steps = np.abs(np.diff(results.simulated.values))
    noise = _noise(results)
    summary = (
        f"Watched: {results.walk.quantity}; {results.poses.min()} to "
        f"{results.poses.max()} stable poses. The methods are farthest apart at "
        f"{results.values[row]:.3g}: {_title(low)} {points(shares[low])} %, "
        f"{_title(high)} {points(shares[high])} %, {points(distance)} points. The "
        f"simulation's standard error is at most {points(noise.max(), 2)} points, its "
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
    rows = markdown_table(head, [_row(results, curve) for curve in results.curves])
    return "\n".join([*wrap(summary, WIDTH), "", rows])


def _row(results: WalkResults, curve: Curve) -> tuple[str, ...]:
    away = np.abs(curve.values - results.simulated.values)
    worst = int(np.argmax(away))
    sizes = [abs(jump.size) for jump in curve.change.jumps]
    outside_noise = int((away > 4.0 * _noise(results)).sum())
    return (
        _title(curve.method),
        str(len(sizes)),
        points(max(sizes)) if sizes else "",
        points(0.01 * curve.change.slope, 3),
        f"{results.walk.value(curve.change.slope_at):.3g}"
        if curve.change.slope
        else "",
        points(float(away[worst])),
        f"{results.values[worst]:.3g}",
        f"{outside_noise} of {len(results.values)}",
    )


def _noise(results: WalkResults) -> Array:
    """Standard error of the simulation at each value, never 0."""
    n = results.simulated.settled
    q = (results.simulated.values * n + 0.5) / (n + 1.0)
    return np.asarray(np.sqrt(q * (1.0 - q) / n))


def _title(name: str) -> str:
    return ESTIMATORS[name].title


PAPER = "the paper's estimators and those before it"


def draw_walk(results: WalkResults) -> Figure:
    """Estimators of the paper on the left, newer ones on the right, the simulation in
    both.
    """
    walk = results.walk
    simulated = results.simulated
    paper = [
        _curve(results, curve) for curve in results.curves if curve.method in ERRORS
    ]
    ours = [
        _curve(results, curve) for curve in results.curves if curve.method not in ERRORS
    ]
    with_drops = "drops with it" if len(ours) == 1 else "hybrid"
    heading = f"{listed([curve.label for curve in ours])}, and {with_drops}"
    ours.append(WalkCurve(f"hybrid, {COMBINED_DROPS} drops", results.combined))
    drops = int(simulated.settled.max())
    return walk_figure(
        results.values,
        [WalkPanel(PAPER, paper), WalkPanel(heading, ours, paper, "those on the left")],
        np.array([simulated.values, simulated.low, simulated.high]),
        walk.parameter,
        walk.quantity,
        logarithmic=walk.logarithmic,
        mark=walk.mark,
        title=walk.title,
        note=f"Bars: {100.0 * LEVEL:g} % intervals of {drops} drops."
        f"{_tolerance(results)} {SCENE}",
    )


def _tolerance(results: WalkResults) -> str:
    """The cluster tolerance, where the walk does not change it."""
    walk = results.walk
    changed = walk.make(float(results.values[0])).cluster_tolerance is not None
    return "" if changed else f" Cluster tolerance {walk.cluster_tolerance:g}."


def draw_reliability(results: StabilityResults) -> Figure:
    """Expected against true errors, a panel a method."""
    return reliability_figure(
        [
            (
                ESTIMATORS[name].title if name in ESTIMATORS else name,
                np.array([(parts.expected, parts.true, parts.error) for parts in bins]),
            )
            for name, bins in results.reliability.items()
        ]
    )


def _curve(results: WalkResults, curve: Curve) -> WalkCurve:
    jumps = [
        (results.walk.value(jump.position), jump.size) for jump in curve.change.jumps
    ]
    return WalkCurve(ESTIMATORS[curve.method].title, curve.values, jumps)
