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

"""The documents on accuracy: measures and writes every table and figure of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lab.frame.documents import save_figure, write_json, write_page
from ros_pose_stats.base.files import write_whole
from ros_pose_stats.base.text import listed
from ros_pose_stats.core.estimators.published import nonlinear

from .chart import PLANS, QUICK, ChartResults, chart, chart_text
from .dataset import Dataset, shipped_dataset, shipped_datasets
from .errors.partition import INTERVAL_LEVEL, noise_of
from .errors.simulated_poses import SimulatedPoses, pooled
from .figures.probabilities import Panel, estimators_figure, noise_figure
from .figures.speed_accuracy import SUBTITLE, speed_accuracy_figure
from .prisms import PrismResults, prisms, prisms_text
from .prisms.prism_results import draw_prisms
from .table import TableResults, table, table_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

QUICK_DROPS = 200
PAGE = "accuracy.md"


class Documents(NamedTuple):
    """Everything that the documents show.

    Attributes
    ----------
    first : Dataset
        Dataset of the first table, the figures and the chart.
    tables : list of TableResults
    bars : PrismResults
    measured : ChartResults
    """

    first: Dataset
    tables: list[TableResults]
    bars: PrismResults
    measured: ChartResults


def measure_documents(
    *, quick: bool = False, say: Callable[[str], object] = lambda _: None
) -> Documents:
    """Measure everything; nothing is written.

    Parameters
    ----------
    quick : bool
        Whether to measure one dataset, fewer bodies and drops, to see that it works.
    say : callable, optional
        Called with what is being measured.
    """
    datasets = [shipped_dataset()] if quick else shipped_datasets()
    tables = []
    for dataset in datasets:
        say(f"table of shift {dataset.spec.shift:g} ({dataset.spec.shift_moment})")
        tables.append(table(dataset, rerun=not quick))
    say("square prisms")
    bars = prisms(QUICK_DROPS, QUICK_DROPS) if quick else prisms()
    measured = chart(datasets[0], QUICK if quick else PLANS, on_progress=say)
    return Documents(datasets[0], tables, bars, measured)


def write_documents(documents: Documents, folder: Path) -> list[Path]:
    """Write `measured/accuracy.md`, its figures and numbers, whole or not at all.

    Parameters
    ----------
    found : Documents
    folder : Path
        Created where it does not exist; other files in it stay.

    Returns
    -------
    list of Path
        What was written.
    """
    return write_page(
        folder,
        PAGE,
        accuracy_page(documents.tables, documents.bars, documents.measured),
        {
            "noise": draw_noise(documents.first, documents.tables[0]),
            "estimators": draw_estimators(documents.first, documents.tables[0]),
            "prisms": draw_prisms(documents.bars),
            "speed_accuracy": draw_chart(documents.measured),
        },
        {
            "table": [results.as_dict() for results in documents.tables],
            "prisms": documents.bars.as_dict(),
            "chart": documents.measured.as_dict(),
        },
    )


def write_chart(results: ChartResults, file: Path) -> list[Path]:
    """Draw the chart to a file, and write its numbers to one that ends in .json beside
    it.
    """
    figure = draw_chart(results)

    def write(staging: Path) -> None:
        save_figure(figure, staging / file.name)
        write_json(staging / f"{file.stem}.json", results.as_dict())

    return write_whole(file.parent, write)


def write_prisms(results: PrismResults, file: Path) -> list[Path]:
    """Draw the square prisms to a file."""
    figure = draw_prisms(results)
    return write_whole(
        file.parent, lambda staging: save_figure(figure, staging / file.name)
    )


INTRODUCTION = """# Accuracy

Written by `python -m study figures -o docs`; edits here are lost. The numbers behind
the tables and figures are in `table.json`, `prisms.json` and `chart.json` in
`docs/measured/numbers`. All of it holds for the drop simulation's own model: a rigid
part on a rigid, frictionless, horizontal plate, released from rest in a random
orientation. Against a real plate expect some 5 points on top (see the dice below).

Errors are root mean squares over stable poses, the paper's σ(e, p) (Eqs. 1 to 4): the
deviation from simulated probabilities with the noise of the finite number of drops
taken off. The noise is taken without bias, s (1 - s) / (n - 1). No poses are merged
(cluster tolerance 0).
"""

CHART = """## Speed against accuracy

![Time of a part on one core against the error of its probabilities, for four kinds of
part; a stair joins the methods that no other beats in
both](../figures/speed_accuracy.png)

Time is that of the processor from the mesh arrays to the statistics, on one core, the
median over parts; compiled kernels are warm. Other work on the machine slows all
methods down, so ratios count. The error is pooled over the restitutions. That of the
drop simulation is the noise of so many drops; that of others is measured against it,
that of the default answer and of `hybrid` with drops of their own for every body, or
the first 200. The default answer, `auto` without a target, drops until its error is
within two points with 90 % confidence, but at least 400 times, unless its budget of
impacts and steps ends before; n is the median. The paper's estimators are pale. Larger
parts are hulls of random points on ellipsoids of different proportions. The machined
and turned parts (shafts, brackets, rings, screws, plates, gears) are taken as users'
files are: poses by persistence, round surfaces at 192 sides a turn. `trimesh.poses` is
timed without the making of its mesh object.
"""

TABLES = """## Estimators on random polyhedra

![The estimators' predictions against simulated
probabilities](../figures/estimators.png)

![What the noise of 100 drops does to a perfect estimator](../figures/noise.png)

The paper's text on how far the centre of mass is shifted does not give its dataset, so
every table names the shift: its scale, and whether it is measured in roots of the
principal moments of inertia over the mass, as printed, or of the second moments.
`python -m study dataset` makes such datasets; those below come with the package.
"""

PRISMS = """## Square prisms and dice that were rolled

![Probability that a square prism comes to rest on a side](../figures/prisms.png)
"""


def accuracy_page(
    tables: Sequence[TableResults], bars: PrismResults, measured: ChartResults
) -> str:
    """The whole page, Markdown."""
    return "\n".join(
        [
            INTRODUCTION,
            CHART,
            chart_text(measured),
            "",
            TABLES,
            *(f"{table_text(results)}\n" for results in tables),
            PRISMS,
            prisms_text(bars),
            "",
        ]
    )


CURVE = np.arange(201) / 200.0
FITTED = "qse"
"""The estimator that Eq. 6 is fitted to."""


def draw_noise(dataset: Dataset, results: TableResults) -> Figure:
    """Fig. 2: the simulated probabilities against binomial numbers drawn from them."""
    drops = results.first
    simulated = simulate_first_drops(dataset, results)
    counts = np.random.default_rng(dataset.spec.seed).binomial(
        drops, simulated.probability
    )
    return noise_figure(
        counts / drops, simulated.probability, drops, noise_of(simulated, drops).error
    )


def draw_estimators(dataset: Dataset, results: TableResults) -> Figure:
    """Fig. 4: every estimator against the first drops, all restitutions."""
    simulated = simulate_first_drops(dataset, results).probability
    estimates = results.estimates.values()
    panels = [
        Panel(
            row.title,
            np.concatenate([estimate[row.name] for estimate in estimates]),
            simulated,
            row.pooled.error,
            row.first.largest,
            (CURVE, nonlinear(CURVE)) if row.name == FITTED else None,
        )
        for row in results.rows
        if row.first is not None
    ]
    return estimators_figure(panels, results.first)


def draw_chart(results: ChartResults) -> Figure:
    """Time of a part against error, one panel a size of part."""
    restitutions = listed([f"{size:g}" for size in results.spec.restitutions])
    return speed_accuracy_figure(
        [size.panel() for size in results.sizes],
        INTERVAL_LEVEL,
        SUBTITLE.format(restitutions.replace(" and", "\nand")),
    )


def simulate_first_drops(dataset: Dataset, results: TableResults) -> SimulatedPoses:
    """The first drops, as many as in the paper, at every restitution."""
    return pooled(
        [
            dataset.simulated(restitution, results.first)
            for restitution in dataset.spec.restitutions
        ]
    )
