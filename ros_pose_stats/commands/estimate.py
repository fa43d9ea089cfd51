"""`estimate PART`: stable poses and their probabilities by the analytic estimators."""

from __future__ import annotations

import argparse
import json
import sys

from .part_options import add_part_options, add_scene_options, part_of
from .slow_start import announce_slow_start

METHODS = ("area", "csae", "adre", "qse", "pqse", "nqse", "eae", "meae", "combined")
DEFAULT_METHOD = "combined"


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command."""
    command = commands.add_parser(
        "estimate", help="estimate the pose statistics of a part at once",
        description="Estimate the stable poses of a part and their resting probabilities.")
    add_part_options(command)
    command.add_argument("--method", choices=(*METHODS, "all"), default=DEFAULT_METHOD,
                         metavar="NAME", help=f"{', '.join(METHODS)} or all "
                         "(default: %(default)s)")
    add_scene_options(command)
    command.add_argument("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Estimate and print."""
    with announce_slow_start():
        from ..estimators import ESTIMATORS, estimate

        part = part_of(options)
        methods = list(ESTIMATORS) if options.method == "all" else [options.method]
        found = [estimate(part, method, restitution=options.restitution,
                          drop_height=options.drop_height,
                          cluster_tolerance=options.cluster_tolerance) for method in methods]
    if options.json:
        plain = [statistics.as_dict() for statistics in found]
        json.dump(plain if options.method == "all" else plain[0], sys.stdout, allow_nan=False)
        print()
    else:
        from .tables import comparison, report

        print(comparison(part, found) if options.method == "all" else report(part, found[0]))
    return 0
