"""`flips PART`: where a kicked part comes to rest, and what kicking gains a feeder."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ...errors import RequestError
from ...records.scene import DEFAULT_DROPS
from ..arguments import JoinIndices, add_part_options, add_scene_options, read_count, read_indices
from ..drop_runs import load_part_and_kernels
from ..progress_bar import ProgressBar
from ..running import INTERRUPTED, print_json, stop_on_interrupt
from .flip_sweep import show_bounded, sweep, write_feeding

if TYPE_CHECKING:
    from ...records import FlipStatistics, Part, PoseStatistics
    from ...statistics.feeding import Feeding

DEFAULT_RATE = 60.0
DEFAULT_FLIPS = 2000


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command."""
    command = commands.add_parser(
        "flips", help="kick a part out of each of its poses and count where it comes to rest",
        description="Kick a part, lying in each of its poses, from below at a point of its "
        "contact polygon, and count where it comes to rest. With the wanted poses it says what "
        "a feeder gets by kicking parts that lie wrong, and by dropping them again; a sweep "
        "over kick heights finds the kick that feeds fastest.",
        examples=("ros_pose_stats flips demo/clamp.stl --unit mm --kick 0.02 --wanted 0 1",
                  "ros_pose_stats flips demo/clamp.stl --unit mm --sweep --wanted 0 1 "
                  "--png kicks.png"))
    add_part_options(command)
    kicks = command.add_mutually_exclusive_group(required=True)
    kicks.add_argument("--kick", type=float, metavar="H",
                       help="energy of a kick over the part's weight, in metres: as high would "
                       "it throw the part without turning it")
    kicks.add_argument("--sweep", type=float, nargs="*", metavar="H",
                       help="with --wanted: these kick heights, in metres, one after the other "
                       "(default: thirteen from a twentieth of the part's radius to five radii)")
    command.add_argument("--png", metavar="FILE",
                         help="draw the accepted parts a minute over the kick heights of --sweep, "
                         "as FILE.png")
    command.add_argument("--flips", type=read_count, metavar="N",
                         help=f"kicks out of each pose (default: {DEFAULT_FLIPS}; of a sweep "
                         f"500 at each height)")
    add_scene_options(command)
    command.add_argument("--wanted", type=read_indices, nargs="+", action=JoinIndices,
                         metavar="I", help="indices of the poses that are accepted, "
                         "for instance 0 1 or 0-3")
    command.add_argument("--rate", type=float, default=DEFAULT_RATE, metavar="R",
                         help="parts that can be dropped a minute (default: %(default)s)")
    command.add_argument("--cycle-time", type=float, default=1.0, metavar="S",
                         help="seconds from one kick to the next (default: %(default)s)")
    command.add_argument("--drops", type=read_count, default=DEFAULT_DROPS, metavar="N",
                         help="drops for the poses of parts that are dropped "
                         "(default: %(default)s)")
    command.add_argument("--seed", type=read_count, metavar="S",
                         help="the same seed gives the same counts (default: a fresh one, "
                         "which is printed)")
    command.add_argument("--workers", type=read_count, metavar="W",
                         help="number of threads (default: all cores)")
    command.add_argument("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Kick, drop where poses are wanted, and print."""
    if options.sweep is not None:
        return sweep(options)
    if options.png is not None:
        raise RequestError("--png with --sweep", "--png alone", "add --sweep and --wanted")
    part = load_part_and_kernels(options)
    from ...simulation.flips import simulate_flips
    from ...simulation.simulate import simulate

    fresh: PoseStatistics | None = None
    merging = {"cluster_tolerance": options.cluster_tolerance, "round_sides": options.round_sides}
    with stop_on_interrupt() as interrupted, ProgressBar(sys.stderr) as bar:
        found = simulate_flips(
            part, options.kick, DEFAULT_FLIPS if options.flips is None else options.flips,
            options.restitution, options.seed, options.workers,
            lambda done, total: bar.draw(done / total, f"{done} of {total} flips"), interrupted,
            **merging)
        if options.wanted is not None and not interrupted():
            fresh = simulate(part, options.drops, options.restitution, found.seed,
                             options.drop_height, workers=options.workers, on_progress=bar.show,
                             should_stop=interrupted, **merging)
    stopped = interrupted()
    ways = {} if fresh is None or stopped else _feedings(options, found, fresh)
    if fresh is not None:
        from ...statistics.pose_groups import warn_of_alike

        found = replace(found, warnings=(*found.warnings, *warn_of_alike(fresh, options.wanted)))
    if options.json:
        extra: dict[str, Any] = {"interrupted": True} if stopped else {}
        if ways:
            extra["feeding"] = {name: write_feeding(way) for name, way in ways.items()}
        print_json({**found.as_dict(), **extra})
    else:
        print("\n".join(_table(part, found, ways)))
        if stopped:
            print(f"interrupted after {found.flips} flips")
    return INTERRUPTED if stopped else 0


def _feedings(options: argparse.Namespace, found: FlipStatistics,
              fresh: PoseStatistics) -> dict[str, Feeding]:
    """What a feeder gets, both ways."""
    from ...statistics.feeding import drop_afresh, flip_wrong_ones
    from ...statistics.pose_shares import pose_shares

    dropped = pose_shares(fresh)
    return {"dropped_again": drop_afresh(dropped, options.wanted, options.rate),
            "kicked": flip_wrong_ones(dropped, found.counts, options.wanted, options.rate,
                                      options.cycle_time)}


def _table(part: Part, found: FlipStatistics, ways: dict[str, Feeding]) -> list[str]:
    from ...text import Column, columns, millimetres, percent

    settled = found.counts.sum(axis=1)
    heads = [Column("out of"), *(Column(f"{pose.index}") for pose in found.poses), Column("error")]
    rows = [[str(i), *(percent(share) for share in row), percent(float(max(errors)))]
            for i, (row, errors) in enumerate(zip(found.transition.tolist(),
                                                  found.standard_error.tolist(), strict=True))]
    lines = [f"{part.part_id}: kicked by {millimetres(found.kick_height)} mm on a frictionless "
             f"plate, restitution {found.restitution:g}",
             f"{int(settled.sum())} flips, {int(found.unsettled.sum())} unsettled, seed "
             f"{found.seed}", "",
             "into pose, %; the error is the largest standard error of a row",
             *columns(heads, rows)]
    if ways:
        heads = [Column("parts that lie wrong are", left=True), Column("accepted a minute"),
                 Column("drops a part"), Column("flips a part")]
        lines += ["", *columns(heads, [
            [name.replace("_", " "), show_bounded(way.per_minute), show_bounded(way.passes),
             show_bounded(way.flips)] for name, way in ways.items()]),
            "in brackets: 90 % intervals, of the model alone"]
    return [*lines, *(["", *found.warnings] if found.warnings else [])]
