"""A picture of each walk."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...estimators.registry import ESTIMATORS
from ..table.paper import ERRORS
from .run import COMBINED_DROPS, LEVEL, Curve, StabilityResults, WalkResults

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...plots.study.walks import WalkCurve

PAPER = "the paper's estimators and those before it"


def draw_walk(found: WalkResults) -> Figure:
    """The paper's on the left, those that know the scene on the right, the simulation in both."""
    from ...plots.study.walks import WalkCurve, WalkPanel, walk_figure

    walk, simulated = found.walk, found.simulated
    paper = [_curve(found, one) for one in found.curves if one.method in ERRORS]
    ours = [_curve(found, one) for one in found.curves if one.method not in ERRORS]
    ours.append(WalkCurve(f"hybrid, {COMBINED_DROPS} drops", found.combined))
    drops = int(simulated.settled.max())
    return walk_figure(
        found.values, [WalkPanel(PAPER, paper),
                       WalkPanel("split, and drops with it", ours, paper, "those on the left")],
        np.array([simulated.values, simulated.low, simulated.high]), walk.parameter,
        walk.quantity, logarithmic=walk.logarithmic, mark=walk.mark, title=walk.title,
        note=f"Bars: {100.0 * LEVEL:g} % intervals of {drops} drops. Cluster tolerance "
        f"{walk.cluster_tolerance:g}.")


def draw_reliability(found: StabilityResults) -> Figure:
    """Expected against true errors, a panel a method."""
    from ...plots.study.reliability import reliability_figure

    return reliability_figure([
        (ESTIMATORS[name].title if name in ESTIMATORS else name,
         np.array([(one.expected, one.true, one.error) for one in bins]))
        for name, bins in found.reliability.items()])


def _curve(found: WalkResults, one: Curve) -> WalkCurve:
    from ...plots.study.walks import WalkCurve

    jumps = [(found.walk.value(jump.place), jump.size) for jump in one.change.jumps]
    return WalkCurve(ESTIMATORS[one.method].title, one.values, jumps)
