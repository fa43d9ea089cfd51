"""`simulate PART`: pose statistics by dropping the part many times."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from ..records.scene import DEFAULT_DROPS
from .arguments import add_part_options, add_scene_options
from .drop_runs import (
    RunCallbacks,
    add_drop_options,
    add_table_options,
    load_part_and_kernels,
    run_and_report,
)

if TYPE_CHECKING:
    from ..records import PoseStatistics


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command."""
    command = commands.add_parser(
        "simulate", help="drop a part many times and count its poses",
        description="Drop a part many times onto a rigid frictionless plate and count the "
        "poses in which it comes to rest. Ctrl-C stops and reports what has been done.",
        examples=("ros_pose_stats simulate demo/clamp.stl --unit mm --drops 2e4 --seed 7",))
    add_part_options(command)
    add_drop_options(command, DEFAULT_DROPS)
    add_scene_options(command)
    add_table_options(command)
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Simulate and print."""
    part = load_part_and_kernels(options)
    from ..simulation.simulate import simulate

    def start(callbacks: RunCallbacks) -> PoseStatistics:
        return simulate(
            part, options.drops, options.restitution, options.seed, options.drop_height,
            options.target_error, options.workers,
            on_progress=callbacks.on_progress, should_stop=callbacks.should_stop,
            cluster_tolerance=options.cluster_tolerance,
            round_sides=options.round_sides)

    return run_and_report(part, start, options.drops, options)
