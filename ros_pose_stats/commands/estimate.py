"""`estimate PART`: stable poses and their probabilities, at once or with the help of drops."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

from ..errors import RequestError
from ..methods import AUTO, BESIDE_DROPS, DEFAULT_METHOD, METHODS
from ..records.scene import DEFAULT_DROPS
from ..text import listed
from .arguments import add_part_options, add_scene_options, load_named_part, scene_of
from .drop_runs import (
    RunCallbacks,
    add_drop_options,
    add_table_options,
    load_part_and_kernels,
    run_and_report,
)
from .running import announce_slow_start, print_json

if TYPE_CHECKING:
    from ..records import PoseStatistics

CHOICES = {one.name: one for one in METHODS if one.drops != "all"}
ALL = "all"


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command."""
    knowing = listed([f"`{name}`" for name, one in CHOICES.items() if one.knows_scene])
    dropping = "; ".join(f"`{name}` is {CHOICES[name].about}" for name in BESIDE_DROPS)
    command = commands.add_parser(
        "estimate", help="estimate the pose statistics of a part at once",
        description="Estimate the stable poses of a part and the probability of coming to rest "
        f"in each. {knowing} take the restitution and the drop height into account; "
        f"the others ignore them. {dropping}; `choice` in the JSON says what it did and why. "
        "These two alone take the number of drops, the target error, the seed and the workers.",
        examples=("ros_pose_stats estimate demo/clamp.stl --unit mm",
                  "ros_pose_stats estimate demo/clamp.stl --unit auto --density 7850",
                  "ros_pose_stats estimate demo/clamp.stl --unit mm --target-error 0.02 --json",
                  "ros_pose_stats estimate demo/gear.stl --unit mm --method hybrid --drops 500",
                  "ros_pose_stats estimate demo/hex_bolt.stl --unit mm --method all --each"))
    add_part_options(command)
    command.add_argument("--method", choices=(*CHOICES, ALL),
                         default=DEFAULT_METHOD, metavar="NAME",
                         help=f"one of {', '.join(CHOICES)}, or {ALL}, which sets "
                         "every estimator beside the others (default: %(default)s)")
    add_scene_options(command)
    add_drop_options(command, None)
    add_table_options(command, ", or with all methods a list of them")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Estimate and print."""
    if options.method in BESIDE_DROPS and (options.method != AUTO or options.target_error):
        return _estimate_with_drops(options)
    with announce_slow_start():
        from ..estimators.estimate import estimate_in
        from ..estimators.registry import ESTIMATORS

        _check_drops(options)
        part, scene = load_named_part(options), scene_of(options)
        found = [estimate_in(part, scene, method) for method in (
            ESTIMATORS if options.method == ALL else [options.method])]
    if options.json:
        plain = [statistics.as_dict() for statistics in found]
        print_json(plain if options.method == ALL else plain[0])
    else:
        from .tables import comparison, report

        print(comparison(part, found, each=options.each) if options.method == ALL
              else report(part, found[0], each=options.each))
    return 0


def _estimate_with_drops(options: argparse.Namespace) -> int:
    part = load_part_and_kernels(options)
    method, bound = _choose_method(options)

    def start(callbacks: RunCallbacks) -> PoseStatistics:
        return method(
            part, drops=bound, target_error=options.target_error or 0.0,
            restitution=options.restitution, seed=options.seed, drop_height=options.drop_height,
            workers=options.workers, cluster_tolerance=options.cluster_tolerance,
            round_sides=options.round_sides,
            on_progress=callbacks.on_progress, should_stop=callbacks.should_stop)

    return run_and_report(part, start, bound, options)


def _choose_method(options: argparse.Namespace) -> tuple[Callable[..., PoseStatistics], int]:
    """Import the function of the method, and return it with the most drops."""
    if options.method == AUTO:
        from ..planning.auto import MOST_DROPS, auto

        return auto, MOST_DROPS if options.drops is None else options.drops
    from ..planning.hybrid import hybrid

    return hybrid, DEFAULT_DROPS if options.drops is None else options.drops


def _check_drops(options: argparse.Namespace) -> None:
    """Refuse options of drops to a method that makes none; `auto` may make some."""
    if options.method == AUTO:
        from ..simulation.request import drop_request

        drop_request(options.drops, options.seed, workers=options.workers)
        return
    for name in ("drops", "target_error", "seed", "workers"):
        if getattr(options, name) is not None:
            raise RequestError(f"--{name.replace('_', '-')} with a method that drops the part",
                               f"the method {options.method}",
                               f"give --method {' or '.join(BESIDE_DROPS)}, or `simulate` the "
                               "part")
