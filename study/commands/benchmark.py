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

"""The paper's tables and figures, and where methods fail, measured here."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ros_pose_stats.base.errors import RequestError
from ros_pose_stats.base.files import refuse_unwritable
from ros_pose_stats.tools.commands.terminal.arguments import read_count
from ros_pose_stats.tools.commands.terminal.running import (
    ProgressBar,
    announce_slow_start,
    end_on_interrupt,
    output_file,
)

from .dataset import shift_options

if TYPE_CHECKING:
    from ..dataset import Dataset


Options = dict[str, dict[str, Any]]
"""What `add_argument` takes, by the words of the option."""

JSON: Options = {"--json": {"action": "store_true", "help": "print JSON"}}
QUICK: Options = {
    "--quick": {
        "action": "store_true",
        "help": "measure fewer bodies, values and drops",
    }
}
DATASET: dict[str, Any] = {
    "metavar": "FILE",
    "help": "made by `dataset`, instead of a shift (default: what comes with the "
    "package)",
}
FOLDER: dict[str, Any] = {
    "metavar": "DIR",
    "help": "directory into which the page, its numbers and its figures are written",
}
FIGURE_ENDINGS = (".png", ".svg")


def _count(default: int, meaning: str) -> dict[str, Any]:
    """A whole number from 0 up."""
    return {
        "type": read_count,
        "default": default,
        "metavar": "N",
        "help": f"{meaning} (default: %(default)s)",
    }


class Kind(NamedTuple):
    """A kind of study as a command."""

    name: str
    run: Callable[[argparse.Namespace], int]
    summary: str
    description: str
    example: str
    options: Options


def kinds_of_study() -> tuple[Kind, ...]:
    """All kinds but `dataset`, in the order of the help."""
    return (
        Kind(
            "table",
            run_table,
            "Table I beside the paper's figures, from datasets",
            "Compare every estimator with datasets, as Table I of the paper does, and "
            "show the paper's figures beside: errors by restitution, noise, "
            "sensitivity, and the largest deviations, dropped again.",
            "--dataset small.npz",
            {
                **shift_options(None),
                "--dataset": {**DATASET, "nargs": "+"},
                "--no-rerun": {
                    "action": "store_true",
                    "help": "do not drop the largest deviations again",
                },
                **JSON,
            },
        ),
        Kind(
            "prisms",
            run_prisms,
            "Fig. 5: square prisms and Budden's dice",
            "Drop square prisms of many proportions, as in Fig. 5 of the paper, and "
            "the dice that Budden rolled, and show the answer of every estimator "
            "beside.",
            "--drops 200 --dice-drops 400 -o prisms.png",
            {
                "--drops": _count(1000, "drops of each prism at each restitution"),
                "--dice-drops": _count(2000, "drops of each die at each restitution"),
                "--seed": _count(1, "seed of the drops"),
                "-o --output": {
                    "metavar": "FILE",
                    "help": "draw them to a .png or .svg file",
                },
                **JSON,
            },
        ),
        Kind(
            "chart",
            run_chart,
            "speed against accuracy, for four kinds of part",
            "Measure time and error of every method for random polyhedra of three "
            "sizes and for machined and turned parts, and draw one against the other. "
            "A shift or a dataset chooses the bodies of the paper's size.",
            "--quick -o speed_accuracy.png",
            {
                **shift_options(0.0),
                "--dataset": {**DATASET, "nargs": 1},
                **QUICK,
                "-o --output": {
                    "default": "speed_accuracy.png",
                    "metavar": "FILE",
                    "help": "draw it to a .png or .svg file, and write its numbers to "
                    "a .json file beside it (default: %(default)s)",
                },
                **JSON,
            },
        ),
        Kind(
            "stability",
            run_stability,
            "every method along walks through each known trouble",
            "Follow every method along walks through each known trouble: jumps, "
            "slopes, and the distance from simulation.",
            "--quick -o stability",
            {"-o --output": FOLDER, **QUICK, **JSON},
        ),
        Kind(
            "plates",
            run_plates,
            "fitted plates, judged by other parts",
            "Fit restitution and drop height to five of Budden's dice, and to five "
            "parts on plates simulated with friction, and predict the others.",
            "--splits 4",
            {
                "--splits": _count(20, "random choices of the five"),
                "--seed": _count(1, "seed of the choices"),
                "-o --output": FOLDER,
                **JSON,
            },
        ),
        Kind(
            "figures",
            run_figures,
            "table, prisms and chart, into a folder of documents",
            "Measure table, prisms and chart, and write them into a folder of "
            "documents.",
            "--quick -o measured",
            {
                "-o --output": {**FOLDER, "default": "docs"},
                **QUICK,
            },
        ),
    )


def register(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add a command for each kind of study."""
    for kind in kinds_of_study():
        parser = kinds.add_parser(
            kind.name,
            help=kind.summary,
            description=kind.description,
            examples=(f"python -m study {kind.name} {kind.example}",),
            run=kind.run,
        )
        for words, settings in kind.options.items():
            parser.add_argument(*words.split(), **settings)


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
        from ..accuracy_documents import write_prisms
        from ..prisms import prisms, prisms_text

        file = output_file(options.output, FIGURE_ENDINGS) if options.output else None
    with end_on_interrupt(), ProgressBar() as bar:
        results = prisms(
            options.drops,
            options.dice_drops,
            options.seed,
            on_progress=lambda dropped, total: bar.draw(
                dropped / total, f"{dropped} of {total} drops"
            ),
        )
    if file is not None:
        _say_files(write_prisms(results, file))
    _print(options, results.as_dict(), prisms_text(results))
    return 0


def run_chart(options: argparse.Namespace) -> int:
    """Time and error of every method, drawn."""
    with announce_slow_start(), end_on_interrupt():
        from ..accuracy_documents import write_chart
        from ..chart import PLANS, QUICK, chart, chart_text

        file = output_file(options.output, FIGURE_ENDINGS)
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

        _refuse_unwritable(options.output)
    with end_on_interrupt():
        documents = measure_documents(quick=options.quick, say=_say)
    _say_files(write_documents(documents, Path(options.output)))
    return 0


def run_plates(options: argparse.Namespace) -> int:
    """Fitted plates, judged by other parts."""
    with announce_slow_start(), end_on_interrupt():
        from lab.frame.documents import plain

        from ..plates import plates, plates_text, write_plates

        _refuse_unwritable(options.output)
    with end_on_interrupt():
        results = plates(options.splits, options.seed, say=_say)
    if options.output:
        _say_files(write_plates(results, Path(options.output)))
    _print(options, plain(results), plates_text(results))
    return 0


def run_stability(options: argparse.Namespace) -> int:
    """Every method along every walk."""
    with announce_slow_start(), end_on_interrupt():
        from ..stability import as_dict, stability, stability_text, write_stability

        _refuse_unwritable(options.output)
    with end_on_interrupt():
        results = stability(quick=options.quick, on_progress=_say)
    if options.output:
        _say_files(write_stability(results, Path(options.output)))
    _print(options, as_dict(results), stability_text(results))
    return 0


def _datasets(options: argparse.Namespace) -> list[Dataset]:
    """Those that are named; else the reference dataset of a shift, or all."""
    from ..dataset import read_dataset, shipped_dataset, shipped_datasets

    if options.dataset:
        return [read_dataset(file) for file in options.dataset]
    if options.shift is not None:
        return [shipped_dataset(options.shift, options.shift_moment)]
    if options.shift_moment != "inertia":
        raise RequestError(
            "--shift beside --shift-moment",
            f"{options.shift_moment} alone",
            "leave both out for all reference datasets",
        )
    return shipped_datasets()


def _refuse_unwritable(folder: str | None) -> None:
    if folder is not None:
        refuse_unwritable(Path(folder))


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
        print(json.dumps(plain, allow_nan=False))
    else:
        print(text)


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _say_files(files: list[Path]) -> None:
    for file in files:
        _say(f"wrote {file}")
