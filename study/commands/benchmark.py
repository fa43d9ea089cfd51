"""The paper's tables and figures, and where methods fail, measured here."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ros_pose_stats.base.errors import RequestError
from ros_pose_stats.tools.commands.terminal.arguments import read_count
from ros_pose_stats.tools.commands.terminal.running import (
    INTERRUPTED,
    ProgressBar,
    announce_slow_start,
    end_on_interrupt,
    stop_on_interrupt,
)

from .dataset import add_shift_options

if TYPE_CHECKING:
    from ..dataset import Dataset


def register(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add a command for each kind of study."""
    table = _add_kind(
        kinds,
        "table",
        run_table,
        "Table I beside the paper's figures, from datasets",
        "Compare every estimator with datasets, as Table I of the paper does, and show "
        "the paper's figures beside: errors by restitution, noise, sensitivity, "
        "and the largest deviations, dropped again.",
        "table --dataset small.npz",
    )
    _add_dataset_options(table, None)
    table.add_argument(
        "--no-rerun",
        action="store_true",
        help="do not drop the largest deviations again",
    )
    prisms = _add_kind(
        kinds,
        "prisms",
        run_prisms,
        "Fig. 5: square prisms and Budden's dice",
        "Drop square prisms of many proportions, as in Fig. 5 of the paper, and the "
        "dice that Budden rolled, and show the answer of every estimator beside.",
        "prisms --drops 200 --dice-drops 400 -o prisms.png",
    )
    prisms.add_argument(
        "--drops",
        type=read_count,
        default=1000,
        metavar="N",
        help="number of drops of each prism at each restitution (default: %(default)s)",
    )
    prisms.add_argument(
        "--dice-drops",
        type=read_count,
        default=2000,
        metavar="N",
        help="number of drops of each die at each restitution (default: %(default)s)",
    )
    prisms.add_argument(
        "--seed",
        type=read_count,
        default=1,
        metavar="S",
        help="seed of the drops (default: %(default)s)",
    )
    prisms.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="draw them to a .png or .svg file (default ending: .png)",
    )
    chart = _add_kind(
        kinds,
        "chart",
        run_chart,
        "speed against accuracy, for four kinds of part",
        "Measure time and error of every method for random polyhedra of three sizes "
        "and for machined and turned parts, and draw one "
        "against the other. A shift or a dataset chooses the bodies of the paper's "
        "size.",
        "chart --quick -o speed_accuracy.png",
    )
    _add_dataset_options(chart, 0.0)
    chart.add_argument(
        "--quick",
        action="store_true",
        help="measure fewer bodies and drops, and two sizes of polyhedra",
    )
    chart.add_argument(
        "-o",
        "--output",
        default="speed_accuracy",
        metavar="FILE",
        help="draw it to a .png or .svg file (default ending: .png), and write its "
        "numbers to a .json file beside it (default: %(default)s)",
    )
    stability = _add_kind(
        kinds,
        "stability",
        run_stability,
        "every method along walks through each known trouble",
        "Follow every method along walks through each known trouble: jumps, slopes, "
        "and the distance from simulation.",
        "stability --quick -o stability",
    )
    stability.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        help="directory into which measured/stability.md, its numbers and "
        "its figures are written",
    )
    stability.add_argument(
        "--quick", action="store_true", help="measure fewer values and drops"
    )
    plates = _add_kind(
        kinds,
        "plates",
        run_plates,
        "fitted plates, judged by other parts",
        "Fit restitution and drop height to five of Budden's dice, and to five parts "
        "on plates simulated with friction, and predict the others.",
        "plates --splits 4",
    )
    plates.add_argument(
        "--splits",
        type=read_count,
        default=20,
        metavar="N",
        help="random choices of the five (default: %(default)s)",
    )
    plates.add_argument(
        "--seed",
        type=read_count,
        default=1,
        metavar="S",
        help="seed of the choices (default: %(default)s)",
    )
    plates.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        help="directory into which measured/plates.md and its numbers are written",
    )
    figures = _add_kind(
        kinds,
        "figures",
        run_figures,
        "table, prisms and chart, into a folder of documents",
        "Measure table, prisms and chart, and write them into a folder of documents.",
        "figures --quick -o measured",
    )
    figures.add_argument(
        "-o",
        "--output",
        default="docs",
        metavar="DIR",
        help="directory into which measured/accuracy.md, its numbers and its "
        "figures are written (default: %(default)s)",
    )
    figures.add_argument(
        "--quick", action="store_true", help="measure fewer bodies and drops"
    )


def _add_kind(
    kinds: argparse._SubParsersAction[argparse.ArgumentParser],
    name: str,
    run: Callable[[argparse.Namespace], int],
    summary: str,
    description: str,
    example: str,
) -> argparse.ArgumentParser:
    parser = kinds.add_parser(
        name,
        help=summary,
        description=description,
        examples=(f"python -m study {example}",),
    )
    if name != "figures":
        parser.add_argument("--json", action="store_true", help="print JSON")
    parser.set_defaults(run=run)
    return parser


def _add_dataset_options(command: argparse.ArgumentParser, shift: float | None) -> None:
    add_shift_options(command, shift)
    command.add_argument(
        "--dataset",
        nargs="+" if shift is None else None,
        metavar="FILE",
        help="made by `dataset`, instead of a shift (default: what comes with "
        "the package)",
    )


FIGURE_ENDINGS = (".png", ".svg")


def run_table(options: argparse.Namespace) -> int:
    """Compare every estimator with each dataset."""
    with announce_slow_start(), end_on_interrupt():
        from ..table import table, table_text

        datasets = _datasets(options)
    tables = []
    with end_on_interrupt(), ProgressBar() as bar:
        for number, dataset in enumerate(datasets):
            tables.append(
                table(
                    dataset,
                    rerun=not options.no_rerun,
                    on_progress=_bodies(bar, dataset, number, len(datasets)),
                )
            )
    _print(
        options,
        [results.as_dict() for results in tables],
        "\n\n".join(table_text(results) for results in tables),
    )
    return 0


def run_prisms(options: argparse.Namespace) -> int:
    """Square prisms by every estimator and by simulation."""
    with announce_slow_start(), end_on_interrupt():
        from ..prisms import prisms, prisms_text

        file = _figure(options.output) if options.output is not None else None
    with stop_on_interrupt() as interrupted, ProgressBar() as bar:
        results = prisms(
            options.drops,
            options.dice_drops,
            options.seed,
            on_progress=lambda dropped, total: bar.draw(
                dropped / total, f"{dropped} of {total} drops"
            ),
            should_stop=interrupted,
        )
    if file is not None:
        from ..accuracy_documents import write_prisms

        _say_files(write_prisms(results, file))
    stopped = {"interrupted": True} if results.stopped else {}
    _print(options, {**results.as_dict(), **stopped}, prisms_text(results))
    return INTERRUPTED if results.stopped else 0


def run_chart(options: argparse.Namespace) -> int:
    """Time and error of every method, drawn."""
    with announce_slow_start(), end_on_interrupt():
        from ..accuracy_documents import write_chart
        from ..chart import PLANS, QUICK, chart, chart_text

        file = _figure(options.output)
        dataset = _datasets(options)[0]
    with end_on_interrupt():
        results = chart(dataset, QUICK if options.quick else PLANS, on_progress=_say)
    _say_files(write_chart(results, file))
    _print(options, results.as_dict(), chart_text(results))
    return 0


def run_figures(options: argparse.Namespace) -> int:
    """All tables and figures of the documents."""
    with announce_slow_start(), end_on_interrupt():
        from ..accuracy_documents import measure_documents, write_documents

        folder = _writable(Path(options.output))
    with end_on_interrupt():
        documents = measure_documents(quick=options.quick, say=_say)
    _say_files(write_documents(documents, folder))
    return 0


def run_plates(options: argparse.Namespace) -> int:
    """Fitted plates, judged by other parts."""
    with announce_slow_start(), end_on_interrupt():
        from lab.frame.documents import plain

        from ..plates import plates, plates_text, write_plates

        folder = _writable(Path(options.output)) if options.output is not None else None
    with end_on_interrupt():
        results = plates(options.splits, options.seed, say=_say)
    if folder is not None:
        _say_files(write_plates(results, folder))
    _print(options, plain(results), plates_text(results))
    return 0


def run_stability(options: argparse.Namespace) -> int:
    """Every method along every walk."""
    with announce_slow_start(), end_on_interrupt():
        from ..stability import as_dict, stability, stability_text, write_stability

        folder = _writable(Path(options.output)) if options.output is not None else None
    with end_on_interrupt():
        results = stability(quick=options.quick, on_progress=_say)
    if folder is not None:
        _say_files(write_stability(results, folder))
    _print(options, as_dict(results), stability_text(results))
    return 0


def _datasets(options: argparse.Namespace) -> list[Dataset]:
    from ..dataset import read_dataset, shipped_dataset, shipped_datasets

    if options.dataset:
        files = (
            [options.dataset] if isinstance(options.dataset, str) else options.dataset
        )
        return [read_dataset(file) for file in files]
    if options.shift is not None:
        return [shipped_dataset(options.shift, options.shift_moment)]
    if options.shift_moment != "inertia":
        raise RequestError(
            "--shift beside --shift-moment",
            f"{options.shift_moment} alone",
            "leave both out for all reference datasets",
        )
    return shipped_datasets()


def _writable(folder: Path) -> Path:
    """A folder, refused if nothing can be written there."""
    from ros_pose_stats.base.files import refuse_unwritable

    refuse_unwritable(folder)
    return folder


def _figure(output: str) -> Path:
    """Path of a figure; refused if nothing can be written there."""
    path = Path(output)
    if path.name in ("", "..") or output.endswith("/"):
        raise RequestError(
            "the path of a .png or .svg file",
            f"{output!r}",
            "for instance -o figures/chart.png",
        )
    _writable(path.parent)
    return path if path.suffix in FIGURE_ENDINGS else path.with_name(f"{path.name}.png")


def _bodies(
    bar: ProgressBar, dataset: Dataset, number: int, total: int
) -> Callable[[int], object]:
    def show(done: int) -> None:
        bodies = dataset.spec.bodies
        bar.draw(
            (number + done / bodies) / total,
            f"dataset {number + 1} of {total}, {done} of {bodies} bodies",
        )

    return show


def _print(options: argparse.Namespace, plain: Any, text: str) -> None:
    if options.json:
        json.dump(plain, sys.stdout, allow_nan=False)
        print()
    else:
        print(text)


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _say_files(files: list[Path]) -> None:
    for file in files:
        _say(f"wrote {file}")
