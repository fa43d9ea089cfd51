"""`benchmark KIND`: the paper's tables and figures, and where methods fail, measured here."""

from __future__ import annotations

import argparse
from collections.abc import Callable

from ..reading import read_count
from .benchmark_runs import run_chart, run_figures, run_prisms, run_stability, run_table
from .dataset import add_shift_options


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command."""
    command = commands.add_parser(
        "benchmark", help="how wrong and how slow each estimator is",
        description="Measure estimators and simulation on the paper's random polyhedra, on "
        "square prisms and on dice that were rolled.",
        examples=("ros_pose_stats benchmark table --dataset small.npz",))
    kinds = command.add_subparsers(dest="kind", required=True, metavar="KIND")
    table = _kind(kinds, "table", run_table, "Table I beside the paper's figures, from datasets",
                  "Compare every estimator with datasets, as Table I of the paper does, and show "
                  "the paper's figures beside: errors by restitution, noise, sensitivity, "
                  "coefficients fitted anew, and the largest deviations, dropped again.",
                  "table --dataset small.npz")
    _add_dataset_options(table, None)
    table.add_argument("--no-rerun", action="store_true",
                       help="do not drop the largest deviations again")
    prisms = _kind(kinds, "prisms", run_prisms, "Fig. 5: square prisms and Budden's dice",
                   "Drop square prisms of many proportions, as in Fig. 5 of the paper, and the "
                   "dice that Budden rolled, and show the answer of every estimator beside.",
                   "prisms --drops 200 --dice-drops 400 -o prisms")
    prisms.add_argument("--drops", type=read_count, default=1000, metavar="N",
                        help="number of drops of each prism at each restitution "
                        "(default: %(default)s)")
    prisms.add_argument("--dice-drops", type=read_count, default=2000, metavar="N",
                        help="number of drops of each die at each restitution "
                        "(default: %(default)s)")
    prisms.add_argument("--seed", type=read_count, default=1, metavar="S",
                        help="seed of the drops (default: %(default)s)")
    prisms.add_argument("-o", "--output", metavar="STEM", help="draw STEM.png and STEM.svg")
    chart = _kind(kinds, "chart", run_chart, "speed against accuracy, for three sizes of part",
                  "Measure time and error of every method for three sizes of part, and draw one "
                  "against the other. A shift or a dataset chooses the bodies of the paper's "
                  "size.",
                  "chart --quick -o speed_accuracy")
    _add_dataset_options(chart, 0.0)
    chart.add_argument("--quick", action="store_true",
                       help="measure fewer bodies and drops, and two sizes of part")
    chart.add_argument("-o", "--output", default="speed_accuracy", metavar="STEM",
                       help="draw STEM.png and STEM.svg and write STEM.json "
                       "(default: %(default)s)")
    stability = _kind(kinds, "stability", run_stability,
                      "every method along walks through each known trouble",
                      "Follow every method along walks through each known trouble: jumps, slopes, "
                      "and the distance from simulation.",
                      "stability --quick -o stability")
    stability.add_argument("-o", "--output", metavar="DIR",
                           help="directory into which study/stability.md, figures/ and "
                           "benchmarks/ are written")
    stability.add_argument("--quick", action="store_true", help="measure fewer values and drops")
    figures = _kind(kinds, "figures", run_figures,
                    "table, prisms and chart, into a folder of documents",
                    "Measure table, prisms and chart, and write them into a folder of documents.",
                    "figures --quick -o measured")
    figures.add_argument("-o", "--output", default="docs", metavar="DIR",
                         help="directory into which study/accuracy.md, figures/ and benchmarks/ "
                         "are written (default: %(default)s)")
    figures.add_argument("--quick", action="store_true", help="measure fewer bodies and drops")


def _kind(kinds: argparse._SubParsersAction[argparse.ArgumentParser], name: str,
          run: Callable[[argparse.Namespace], int], about: str,
          description: str, example: str) -> argparse.ArgumentParser:
    parser = kinds.add_parser(name, help=about, description=description,
                              examples=(f"ros_pose_stats benchmark {example}",))
    if name != "figures":
        parser.add_argument("--json", action="store_true", help="print JSON")
    parser.set_defaults(run=run)
    return parser


def _add_dataset_options(command: argparse.ArgumentParser, shift: float | None) -> None:
    add_shift_options(command, shift)
    command.add_argument("--dataset", nargs="+" if shift is None else None, metavar="FILE",
                         help="made by `dataset`, instead of a shift (default: what comes with "
                         "the package)")
