"""The paper's figures 2 and 4 from a dataset, and the chart."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..estimators.quasi_static import nonlinear
from .chart.run import ChartResults
from .dataset import Dataset
from .dataset.spec import PAPER_RESTITUTIONS
from .errors.partition import INTERVAL_LEVEL
from .errors.simulated_poses import SimulatedPoses, pooled
from .noise import noise_of
from .table import TableResults

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CURVE = np.arange(201) / 200.0
PAPER_SAID = "0.2, 0.5\nand 0.8"
"""As the chart's subtitle has the paper's restitutions."""

CURVED = "qse"
"""The estimator that Eq. 6 is fitted to."""


def draw_noise(dataset: Dataset, found: TableResults) -> Figure:
    """Fig. 2: the simulated probabilities against binomial numbers drawn from them."""
    from ..plots.study.noise import noise_figure

    drops, simulated = found.first, _first(dataset, found)
    drawn = np.random.default_rng(dataset.spec.seed).binomial(drops, simulated.probability)
    return noise_figure(drawn / drops, simulated.probability, drops,
                        noise_of(simulated, drops).error)


def draw_estimators(dataset: Dataset, found: TableResults) -> Figure:
    """Fig. 4: every estimator against the first drops, all restitutions."""
    from ..plots.study.estimators import Panel, estimators_figure

    simulated = _first(dataset, found).probability
    told = found.estimates.values()
    panels = [Panel(row.title, np.concatenate([one[row.name] for one in told]), simulated,
                    row.pooled.error, row.first.largest,
                    (CURVE, nonlinear(CURVE)) if row.name == CURVED else None)
              for row in found.rows]
    return estimators_figure(panels, found.first)


def draw_chart(found: ChartResults) -> Figure:
    """Time of a part against error, one panel a size of part."""
    from ..plots.study.speed_accuracy import SUBTITLE, speed_accuracy_figure

    restitutions = found.spec.restitutions
    said = SUBTITLE if restitutions == PAPER_RESTITUTIONS else SUBTITLE.replace(
        PAPER_SAID, ", ".join(f"{one:g}" for one in restitutions))
    return speed_accuracy_figure([one.panel() for one in found.sizes], level=INTERVAL_LEVEL,
                                 subtitle=said)


def _first(dataset: Dataset, found: TableResults) -> SimulatedPoses:
    """The first drops, as many as in the paper, at every restitution."""
    return pooled([dataset.simulated(one, found.first) for one in dataset.spec.restitutions])
