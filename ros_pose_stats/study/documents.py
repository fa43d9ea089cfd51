"""Measures and writes every table and figure of the benchmark: the documents on accuracy."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from ..plots.files import save_figure
from ..whole_files import write_json, write_whole
from .chart import PLANS, QUICK, ChartResults, chart
from .dataset import Dataset, shipped_dataset, shipped_datasets
from .figures import draw_chart, draw_estimators, draw_noise
from .page import accuracy_page
from .prisms import PrismResults, prisms
from .prisms.figure import draw_prisms
from .table import TableResults, table

QUICK_DROPS = 200
PAGE = Path("study") / "accuracy.md"


class Documents(NamedTuple):
    """What was measured.

    Attributes
    ----------
    first : Dataset
        Behind the first table, the figures and the chart.
    tables : list of TableResults
    bars : PrismResults
    measured : ChartResults
    """

    first: Dataset
    tables: list[TableResults]
    bars: PrismResults
    measured: ChartResults


def measure_documents(*, quick: bool = False,
                      say: Callable[[str], object] = lambda _: None) -> Documents:
    """Measure everything; nothing is written.

    Parameters
    ----------
    quick : bool
        One dataset, fewer bodies and drops; to see that it works.
    say : callable, optional
        Told what is being measured.
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


def write_documents(found: Documents, folder: Path) -> list[Path]:
    """Write `study/accuracy.md`, `figures/` and `benchmarks/`, whole or not at all.

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
    figures = {"noise": draw_noise(found.first, found.tables[0]),
               "estimators": draw_estimators(found.first, found.tables[0]),
               "prisms": draw_prisms(found.bars), "speed_accuracy": draw_chart(found.measured)}
    numbers: dict[str, Any] = {"table": [one.as_dict() for one in found.tables],
                               "prisms": found.bars.as_dict(),
                               "chart": found.measured.as_dict()}

    def write(aside: Path) -> None:
        for name, figure in figures.items():
            save_figure(figure, aside / "figures" / name)
        for name, values in numbers.items():
            write_json(aside / "benchmarks" / f"{name}.json", values)
        (aside / PAGE).parent.mkdir()
        (aside / PAGE).write_text(
            accuracy_page(found.tables, found.bars, found.measured), encoding="utf-8")

    return write_whole(folder, write)


def write_chart(found: ChartResults, stem: Path) -> list[Path]:
    """Draw the chart to `stem.png` and `stem.svg`, its numbers to `stem.json`."""
    figure = draw_chart(found)

    def write(aside: Path) -> None:
        save_figure(figure, aside / stem.name)
        write_json(aside / f"{stem.name}.json", found.as_dict())

    return write_whole(stem.parent, write)


def write_prisms(found: PrismResults, stem: Path) -> list[Path]:
    """Draw the square prisms to `stem.png` and `stem.svg`."""
    figure = draw_prisms(found)
    return write_whole(stem.parent, lambda aside: save_figure(figure, aside / stem.name))
