"""What `benchmark` does: measure, then write and print."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import RequestError
from ..progress_bar import ProgressBar
from ..running import (
    INTERRUPTED,
    announce_slow_start,
    end_on_interrupt,
    print_json,
    stop_on_interrupt,
)

if TYPE_CHECKING:
    from ...study.dataset import Dataset

FILE_ENDINGS = (".png", ".svg", ".json")


def run_table(options: argparse.Namespace) -> int:
    """Compare every estimator with each dataset."""
    with announce_slow_start(), end_on_interrupt():
        from ...study.table import table, table_text

        datasets = _datasets(options)
    found = []
    with end_on_interrupt(), ProgressBar(sys.stderr) as bar:
        for number, dataset in enumerate(datasets):
            found.append(table(dataset, rerun=not options.no_rerun,
                               on_progress=_bodies(bar, dataset, number, len(datasets))))
    _print(options, [one.as_dict() for one in found],
           "\n\n".join(table_text(one) for one in found))
    return 0


def run_prisms(options: argparse.Namespace) -> int:
    """Square prisms by every estimator and by simulation."""
    with announce_slow_start(), end_on_interrupt():
        from ...study.prisms import prisms, prisms_text

        stem = _stem(options.output) if options.output is not None else None
    with stop_on_interrupt() as interrupted, ProgressBar(sys.stderr) as bar:
        found = prisms(options.drops, options.dice_drops, options.seed,
                       on_progress=lambda done, total: bar.draw(
                           done / total, f"{done} of {total} drops"),
                       should_stop=interrupted)
    if stem is not None:
        from ...study.documents import write_prisms

        _say_files(write_prisms(found, stem))
    stopped = {"interrupted": True} if found.stopped else {}
    _print(options, {**found.as_dict(), **stopped}, prisms_text(found))
    return INTERRUPTED if found.stopped else 0


def run_chart(options: argparse.Namespace) -> int:
    """Time and error of every method, drawn."""
    with announce_slow_start(), end_on_interrupt():
        from ...study.chart import PLANS, QUICK, chart, chart_text
        from ...study.documents import write_chart

        stem, dataset = _stem(options.output), _datasets(options)[0]
    with end_on_interrupt():
        found = chart(dataset, QUICK if options.quick else PLANS, on_progress=_say)
    _say_files(write_chart(found, stem))
    _print(options, found.as_dict(), chart_text(found))
    return 0


def run_figures(options: argparse.Namespace) -> int:
    """All tables and figures of the documents."""
    with announce_slow_start(), end_on_interrupt():
        from ...study.documents import measure_documents, write_documents
        from ...whole_files import refuse_unwritable

        folder = Path(options.output)
        refuse_unwritable(folder)
    with end_on_interrupt():
        found = measure_documents(quick=options.quick, say=_say)
    _say_files(write_documents(found, folder))
    return 0


def run_stability(options: argparse.Namespace) -> int:
    """Every method along every walk."""
    with announce_slow_start(), end_on_interrupt():
        from ...study.stability import as_dict, stability, stability_text, write_stability
        from ...whole_files import refuse_unwritable

        folder = Path(options.output) if options.output is not None else None
        if folder is not None:
            refuse_unwritable(folder)
    with end_on_interrupt():
        found = stability(quick=options.quick, on_progress=_say)
    if folder is not None:
        _say_files(write_stability(found, folder))
    _print(options, as_dict(found), stability_text(found))
    return 0


def _datasets(options: argparse.Namespace) -> list[Dataset]:
    from ...study.dataset import read_dataset, shipped_dataset, shipped_datasets

    if options.dataset:
        files = [options.dataset] if isinstance(options.dataset, str) else options.dataset
        return [read_dataset(file) for file in files]
    if options.shift is not None:
        return [shipped_dataset(options.shift, options.shift_moment)]
    if options.shift_moment != "inertia":
        raise RequestError("--shift beside --shift-moment", f"{options.shift_moment} alone",
                           "leave both out for all reference datasets")
    return shipped_datasets()


def _stem(output: str) -> Path:
    """Path of the figures without their endings; refused if nothing can be written there."""
    from ...whole_files import refuse_unwritable

    path = Path(output)
    stem = path.with_suffix("") if path.suffix in FILE_ENDINGS else path
    if stem.name in ("", "..") or output.endswith("/"):
        raise RequestError("a path and the beginning of a file name", f"{output!r}",
                           "for instance -o figures/chart")
    refuse_unwritable(stem.parent)
    return stem


def _bodies(bar: ProgressBar, dataset: Dataset, number: int,
            total: int) -> Callable[[int], object]:
    def show(done: int) -> None:
        bodies = dataset.spec.bodies
        bar.draw((number + done / bodies) / total,
                 f"dataset {number + 1} of {total}, {done} of {bodies} bodies")

    return show


def _print(options: argparse.Namespace, plain: Any, text: str) -> None:
    if options.json:
        print_json(plain)
    else:
        print(text)


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _say_files(files: list[Path]) -> None:
    for file in files:
        _say(f"wrote {file}")
