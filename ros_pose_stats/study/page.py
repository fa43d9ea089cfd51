"""The page on accuracy: every table of the benchmark with its figures."""

from __future__ import annotations

from collections.abc import Sequence

from .chart import ChartResults, chart_text
from .prisms import PrismResults, prisms_text
from .table import TableResults, table_text

INTRODUCTION = """# Accuracy

Written by `ros_pose_stats benchmark figures -o docs`; edits here are lost. The numbers behind the
tables and figures are in `table.json`, `prisms.json` and `chart.json` in `docs/benchmarks`. All of
it holds for the drop simulation's own model: a rigid part on a rigid, frictionless, horizontal
plate, released from rest in a random orientation. Against a real plate expect some 5 points on top
(see the dice below).

Errors are root mean squares over stable poses, the paper's σ(e, p) (Eqs. 1 to 4): the deviation
from simulated probabilities with the noise of the finite number of drops taken off. The noise is
taken without bias, s (1 - s) / (n - 1). No poses are merged (cluster tolerance 0).
"""

CHART = """## Speed against accuracy

![Time of a part on one core against the error of its probabilities, for three sizes of part; a
stair joins the methods that no other beats in both](../figures/speed_accuracy.png)

Time is from the mesh arrays to the statistics, on one core, the median over parts; compiled
kernels are warm. The error is pooled over the restitutions. That of the drop simulation is the
noise of so many drops; that of others is measured against it, that of `hybrid` with n drops of
its own for every body. The paper's estimators are pale. Larger parts are hulls of random
points on ellipsoids of different proportions. `trimesh.poses` is timed without the making of its
mesh object, MuJoCo inside its steps alone; MuJoCo's error holds its own noise.
"""

TABLES = """## Estimators on random polyhedra

![The estimators' predictions against simulated probabilities](../figures/estimators.png)

![What the noise of 100 drops does to a perfect estimator](../figures/noise.png)

The paper's text on how far the centre of mass is shifted does not give its dataset, so every table
names the shift: its scale, and whether it is measured in roots of the principal moments of
inertia over the mass, as printed, or of the second moments. `ros_pose_stats dataset` makes such
datasets; those below come with the package.
"""

PRISMS = """## Square prisms and dice that were rolled

![Probability that a square prism comes to rest on a side](../figures/prisms.png)
"""


def accuracy_page(tables: Sequence[TableResults], bars: PrismResults,
                  measured: ChartResults) -> str:
    """The whole page, Markdown."""
    return "\n".join([
        INTRODUCTION, CHART, chart_text(measured), "", TABLES,
        *(f"{table_text(one)}\n" for one in tables),
        PRISMS, f"```text\n{prisms_text(bars)}\n```", ""])
