"""The figures of the page on speed: which section has one, and how it is drawn."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from ros_pose_stats.plots.files import save_figure
from ros_pose_stats.plots.study.cost import cost_figure, drop_cost_figure

from .growth import STAGES, family
from .results import Section


class Picture(NamedTuple):
    """A figure of a section.

    Attributes
    ----------
    stem : Path
        File relative to the page, without its suffix.
    says : str
        What it shows, for those who do not see it.
    figure : callable
    """

    stem: Path
    says: str
    figure: Callable[[Section], Figure]


def draw(section: Section, docs: Path) -> list[Path]:
    """Draw a section's figure, if it has one, under the folder of the page."""
    if section.name not in PICTURES:
        return []
    picture = PICTURES[section.name]
    return save_figure(picture.figure(section), docs / picture.stem)


def _stages(growth: Section) -> Figure:
    """Stages of the first family of bodies in the rows."""
    first = family(growth.rows[0])
    cells = [row.cells for row in growth.rows if family(row) == first]
    stages = [(stage, [float(each[stage]) for each in cells]) for stage in STAGES]
    return cost_figure([int(each["vertices"]) for each in cells], stages, growth.title)


def _families(growth: Section) -> Figure:
    """Every family of bodies, time of a drop."""
    names = dict.fromkeys(map(family, growth.rows))
    cells = {name: [row.cells for row in growth.rows if family(row) == name] for name in names}
    return drop_cost_figure([(name, [float(each["vertices"]) for each in cells[name]],
                              [float(each["µs a drop"]) for each in cells[name]])
                             for name in names], growth.title)


FIGURES = Path("figures")
PICTURES = {
    "growth": Picture(FIGURES / "cost_against_vertices",
                      "Time of each stage against hull vertices, log-log", _stages),
    "drop_growth": Picture(FIGURES / "drops_against_vertices",
                           "Time of a drop against hull vertices, log-log", _families),
}
