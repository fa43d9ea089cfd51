"""`flips PART`: where a kicked part comes to rest, and what kicking gains a feeder."""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import replace
from typing import TYPE_CHECKING

from ...records.scene import DEFAULT_DROPS
from ...text import Column, columns, millimetres, percent, remarks
from .. import arguments as given, running

if TYPE_CHECKING:
    from ...records import FlipStatistics, Part, PoseStatistics
    from ...statistics.feeding import Feeding

DEFAULT_RATE = 60.0
DEFAULT_FLIPS = 2000


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "flips", help="kick a part out of each of its poses and count where it comes to rest",
        description="Kick a part, lying in each of its poses, from below at a point of its "
        "contact polygon, and count where it comes to rest. With the wanted poses it says what "
        "a feeder gets by kicking parts that lie wrong, and by dropping them again; `feeding` "
        "finds the kick that feeds fastest.",
        examples=("ros_pose_stats flips demo/clamp.stl --unit mm --kick 0.02 --wanted 0 1",))
    given.add_part_options(command)
    command.add_argument("--kick", type=given.read_length, metavar="H", required=True,
                         help="energy of a kick over the part's weight, a height as 0.003 "
                         "(metres) or 3mm: as high would it throw the part without turning it")
    command.add_argument("--flips", type=given.read_count, metavar="N", default=DEFAULT_FLIPS,
                         help="kicks out of each pose (default: %(default)s)")
    given.add_scene_options(command)
    given.add_wanted_option(command, "I", "indices of the poses that are accepted, for "
                            "instance 0 1 or 0-3")
    command.add_argument("--rate", type=float, default=DEFAULT_RATE, metavar="R",
                         help="parts that can be dropped a minute (default: %(default)s)")
    command.add_argument("--cycle-time", type=float, default=1.0, metavar="S",
                         help="seconds from one kick to the next (default: %(default)s)")
    command.add_argument("--drops", type=given.read_count, default=DEFAULT_DROPS, metavar="N",
                         help="drops for the poses of parts that are dropped "
                         "(default: %(default)s)")
    given.add_seed_option(command)
    given.add_workers_option(command)
    given.add_json_option(command)
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Kick, drop where poses are wanted, and print."""
    part = running.load_part_and_kernels(options)
    from ...simulation import flips, simulate

    scene, fresh = given.scene_keywords(options), None
    height = scene.pop("drop_height")
    with running.stop_on_interrupt() as interrupted, running.ProgressBar(sys.stderr) as bar:
        found = flips.simulate_flips(
            part, options.kick, options.flips, seed=options.seed, workers=options.workers,
            on_progress=lambda done, total: bar.draw(
                done / total, f"{done} of {total} flips"),
            should_stop=interrupted, **scene)
        if options.wanted is not None and not interrupted():
            fresh = simulate.simulate(part, options.drops, seed=found.seed, drop_height=height,
                                      workers=options.workers, on_progress=bar.show,
                                      should_stop=interrupted, **scene)
    stopped = interrupted()
    ways = {} if fresh is None or stopped else _feedings(options, found, fresh)
    if fresh is not None:
        from ...statistics.pose_groups import warn_of_alike

        found = replace(found, warnings=(*found.warnings, *warn_of_alike(fresh, options.wanted)))
    if options.json:
        feeding = {name: write_feeding(way) for name, way in ways.items()}
        running.print_json({**found.as_dict(), **({"feeding": feeding} if ways else {})},
                           interrupted=stopped)
    else:
        print("\n".join(_table(part, found, ways)))
        if stopped:
            print(f"interrupted after {found.flips} flips")
    return running.INTERRUPTED if stopped else 0


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
    return [*lines, *remarks(found.warnings, found.notes)]


def write_feeding(found: Feeding) -> dict[str, dict[str, float | None]]:
    """What a feeder gets as plain values; null stands for what is not known or has no bound."""
    return {key: {name: number if math.isfinite(number) else None
                  for name, number in one._asdict().items()}
            for key, one in found._asdict().items()}


def show_bounded(number: tuple[float, float, float]) -> str:
    """A number and its bounds."""
    value, low, high = number
    if math.isnan(low) or math.isnan(high):
        return "no bound" if math.isinf(value) else f"{value:.3g}"
    return f"{value:.3g} ({low:.3g} to {high:.3g})"
