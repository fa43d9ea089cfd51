"""`flips PART`: where a kicked part comes to rest, and what kicking gains a feeder."""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ...errors import RequestError
from ...records.scene import DEFAULT_DROPS
from ...text import Column, columns, listed, millimetres, percent
from .. import arguments as given, running

if TYPE_CHECKING:
    from ...planning.kick_sweep import KickSweep
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
        "a feeder gets by kicking parts that lie wrong, and by dropping them again; a sweep "
        "over kick heights finds the kick that feeds fastest.",
        examples=("ros_pose_stats flips demo/clamp.stl --unit mm --kick 0.02 --wanted 0 1",
                  "ros_pose_stats flips demo/clamp.stl --unit mm --sweep --wanted 0 1 "
                  "--png kicks.png"))
    given.add_part_options(command)
    kicks = command.add_mutually_exclusive_group(required=True)
    kicks.add_argument("--kick", type=given.read_length, metavar="H",
                       help="energy of a kick over the part's weight, a height as 0.003 (metres) "
                       "or 3mm: as high would it throw the part without turning it")
    kicks.add_argument("--sweep", type=given.read_length, nargs="*", metavar="H",
                       help="with --wanted: these kick heights, one after the other (default: "
                       "thirteen from a twentieth of the part's radius to five radii)")
    command.add_argument("--png", metavar="FILE",
                         help="draw the accepted parts a minute over the kick heights of --sweep, "
                         "as FILE.png")
    command.add_argument("--flips", type=given.read_count, metavar="N",
                         help=f"kicks out of each pose (default: {DEFAULT_FLIPS}; of a sweep "
                         f"500 at each height)")
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
    if options.sweep is not None:
        return sweep(options)
    if options.png is not None:
        raise RequestError("--png with --sweep", "--png alone", "add --sweep and --wanted")
    part = running.load_part_and_kernels(options)
    from ...simulation import flips, simulate

    scene, fresh = given.scene_keywords(options), None
    height = scene.pop("drop_height")
    with running.stop_on_interrupt() as interrupted, running.ProgressBar(sys.stderr) as bar:
        found = flips.simulate_flips(
            part, options.kick, DEFAULT_FLIPS if options.flips is None else options.flips,
            seed=options.seed, workers=options.workers,
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
    return [*lines, *(["", *found.warnings] if found.warnings else [])]


def sweep(options: argparse.Namespace) -> int:
    """Drop, kick from every height, print, and draw where that is wanted."""
    if options.wanted is None:
        raise RequestError("--wanted with --sweep", "--sweep alone",
                           "name the poses that are accepted; `ros_pose_stats estimate` lists "
                           "them")
    picture = None if options.png is None else running.output_file(options.png, (".png",))
    part = running.load_part_and_kernels(options)
    from ...planning.kick_sweep import SWEEP_FLIPS, sweep_kicks
    from ...simulation.flips import check_kick
    from ...simulation.simulate import simulate
    from ...statistics.feeding import check_cycle_time, check_rate
    from ...statistics.pose_groups import warn_of_alike

    for height in options.sweep:
        check_kick(height)
    check_rate(options.rate)
    check_cycle_time(options.cycle_time)
    with running.stop_on_interrupt() as interrupted, running.ProgressBar(sys.stderr) as bar:
        fresh = simulate(part, options.drops, seed=options.seed, workers=options.workers,
                         on_progress=bar.show, should_stop=interrupted,
                         **given.scene_keywords(options))
        fresh = replace(fresh, warnings=(*fresh.warnings, *warn_of_alike(fresh, options.wanted)))
        found = None if interrupted() else sweep_kicks(
            part, fresh, options.wanted, options.rate, options.cycle_time, options.sweep,
            SWEEP_FLIPS if options.flips is None else options.flips, fresh.seed, options.workers,
            lambda done, total: bar.draw(done / total, f"{done} of {total} flips"), interrupted)
    stopped = interrupted()
    if options.json:
        running.print_json(_plain(fresh, found), interrupted=stopped)
    else:
        print("\n".join(_sweep_table(fresh, found) if found and found.kicks else
                        [f"{fresh.part_id}: {fresh.scene}"]))
        if stopped:
            print(f"interrupted after {len(found.kicks) if found else 0} kick heights")
    if picture is not None and found is not None and found.kicks:
        from ...files import write_file
        from ...plots import files, shares

        write_file(picture, files.figure_png(shares.kick_figure(found)))
    return running.INTERRUPTED if stopped else 0


def _plain(fresh: PoseStatistics, found: KickSweep | None) -> dict[str, Any]:
    """The sweep as plain values, as far as it came."""
    names = ("part_id", "part_digest", "radius", "restitution", "drop_height",
             "cluster_tolerance", "round_sides", "drops", "seed", "version")
    plain = {**{name: getattr(fresh, name) for name in names}, "warnings": list(fresh.warnings)}
    if found is None:
        return plain
    return {**plain, "wanted": list(found.wanted), "rate": found.rate,
            "cycle_time": found.cycle_time, "dropped_again": write_feeding(found.afresh),
            "kicks": [{"kick_height": one.kick_height, "flips": one.flips.flips,
                       "feeding": write_feeding(one.feeding)} for one in found.kicks],
            "best": found.best.kick_height if found.kicks else None,
            "near_best": [one.kick_height for one in found.near_best] if found.kicks else []}


def _sweep_table(fresh: PoseStatistics, found: KickSweep) -> list[str]:
    best, near = found.best, {one.kick_height for one in found.near_best}
    heads = [Column("kick height", "mm"), Column("accepted a minute"), Column("flips a part"),
             Column("", left=True)]
    rows = [[millimetres(one.kick_height), show_bounded(one.feeding.per_minute),
             show_bounded(one.feeding.flips),
             "fastest" if one is best else "as fast" if one.kick_height in near else ""]
            for one in found.kicks]
    return [f"{fresh.part_id}: {fresh.scene}; flips out of each pose: "
            f"{best.flips.flips // len(fresh.poses)} at each height, seed {fresh.seed}",
            f"wanted: {listed(found.wanted)}; {found.rate:g} parts dropped a minute, "
            f"{found.cycle_time:g} s from kick to kick", "", *columns(heads, rows),
            f"dropped again: {show_bounded(found.afresh.per_minute)} accepted a minute",
            "in brackets: 90 % intervals, of the model alone; as fast: within the interval of "
            "the fastest", *(["", *fresh.warnings] if fresh.warnings else [])]


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
