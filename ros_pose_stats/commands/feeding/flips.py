"""`flips PART` and `feeding PART`: where a kicked part comes to rest, and a feeder's plan."""

import argparse
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ... import text
from ...errors import RequestError
from ...records import scene as scenes
from ...text import Column, columns, percent, remarks, several, three_digits
from .. import arguments as given, running

if TYPE_CHECKING:
    from ...records import FlipStatistics, Index, Part, PoseStatistics
    from ...statistics.feeding import Feeding
    from ...statistics.feeding_plan import FeederCell, FeedingPlan

DEFAULT_FLIPS = 2000


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "flips", help="kick a part out of each of its poses and count where it comes to rest",
        description="Kick a part, lying in each of its poses, from below at a point of its "
        "contact polygon, and count where it comes to rest. With the wanted poses it says what "
        "a feeder gets by kicking parts that lie wrong, and by dropping them again; `feeding` "
        "finds the kick that feeds fastest. With flips that a cell has counted it gives the "
        "matrix of each of the feeder's speeds: what was counted, with the model's kick that "
        "explains it best where little was.",
        examples=("ros_pose_stats flips demo/clamp.stl --unit mm --kick 0.02 --wanted 0 1",),
        run=run)
    given.add_part(command, *given.POSES_OF)
    kicks = command.add_mutually_exclusive_group(required=True)
    kicks.add_argument("--kick", **given.OPTIONS["--kick"])
    add_counts_option(kicks)
    command.add_argument("--flips", type=given.read_count, metavar="N", default=DEFAULT_FLIPS,
                         help="kicks out of each pose, with --counts at each of thirteen heights "
                         "(default: %(default)s)")
    given.add(command, "--drops", default=scenes.DEFAULT_DROPS, help="drops for the poses of "
              "parts that are dropped (default: %(default)s)")
    given.add(command, *given.SCENE, "--wanted", "--rate", "--cycle-time", "--seed", "--workers",
              "--json")


def add_counts_option(command: argparse._ActionsContainer) -> None:
    """Add `--counts`."""
    command.add_argument("--counts", metavar="FILE", help="CSV file of flips that were counted, "
                         "with the columns speed (its name), from and to (index of a pose), count")


def read_flips(file: str | None, poses: int) -> "dict[str, Index]":
    """Flips (K, K) from pose to pose by the feeder's speed; of no file, none."""
    import numpy as np

    from ...plates.counts import read_table

    found: dict[str, Index] = {}
    rows = [] if file is None else read_table(Path(file), "speed, from, to, count", "slow,3,0,41")
    for speed, (before, after, count) in rows:
        if max(before, after) >= poses:
            raise RequestError(f"poses 0 to {poses - 1}", f"{max(before, after)} in {file}",
                               "count with the numbers that estimate shows")
        found.setdefault(speed, np.zeros((poses, poses), np.int64))[before, after] += count
    if none := [speed for speed, counts in found.items() if not counts.any()]:
        raise RequestError("flips at every speed", f"none at {none[0]} in {file}",
                           "count some, or leave the speed out")
    return found


def run(options: argparse.Namespace) -> int:
    """Kick, drop where poses are wanted, and print."""
    part = running.load_part_and_kernels(options)
    from ...resting.poses import poses_in
    from ...simulation import flips, request as requests, simulate
    from ...statistics import feeding, pose_groups

    scene, fresh = given.scene_of(options), None
    resting = poses_in(part, scene)
    counted = read_flips(options.counts, len(resting.poses))
    requests.drop_request(options.drops, options.seed)
    if options.wanted is not None:
        feeding.check_wanted(options.wanted, len(resting.poses))
        feeding.check_rate(options.rate, options.cycle_time)
    request = requests.drop_request(options.flips, options.seed, 0.0, options.workers)
    with running.stop_on_interrupt() as interrupted, running.ProgressBar(sys.stderr) as bar:
        watch = requests.Watch.of(None, interrupted)
        if counted:
            kicks = flips.flips_by_kick(
                part, scene, flips.usual_kicks(resting.body.radius), request, watch,
                lambda done, total: bar.draw(done / total, f"kick {done + 1} of {total}"))
            found = [] if interrupted() else [feeding.learn_flips(kicks, each, speed)
                                              for speed, each in counted.items()]
        else:
            found = [flips.count_flips(
                part, scene, options.kick, request, watch,
                lambda done, total: bar.draw(done / total, f"{done} of {total} flips"))]
        if options.wanted is not None and not interrupted():
            fresh = simulate.simulate(part, options.drops, seed=request.seed,
                                      workers=options.workers, on_progress=bar.show,
                                      should_stop=interrupted, **given.scene_keywords(options))
    stopped, speeds, tables = interrupted(), [], []
    dropped = None if fresh is None or stopped else pose_groups.pose_shares(fresh)
    warnings = [] if fresh is None else [
        *fresh.warnings, *pose_groups.warn_of_alike(fresh, options.wanted)]
    for each in found:
        each = replace(each, warnings=tuple(dict.fromkeys((*each.warnings, *warnings))))
        ways = {} if dropped is None else {
            "dropped_again": feeding.drop_afresh(dropped, options.wanted, options.rate),
            "kicked": feeding.flip_wrong_ones(dropped, each.counts, options.wanted, options.rate,
                                              options.cycle_time)}
        speeds.append({**each.as_dict(), **({"feeding": ways} if ways else {})})
        tables.append("\n".join(_table(part, each, ways)))
    return running.print_answer(
        options, lambda: {"speeds": speeds} if options.counts else speeds[0],
        lambda: ["\n\n".join(tables)],
        f"interrupted after {sum(each.flips for each in found)} flips" if stopped else "")


def _table(part: "Part", found: "FlipStatistics", ways: "dict[str, Feeding]") -> list[str]:
    heads = [Column("out of"), *(Column(f"{pose.index}") for pose in found.poses), Column("error")]
    rows = [[str(i), *(percent(share) for share in row), percent(float(max(errors)))]
            for i, (row, errors) in enumerate(zip(found.transition.tolist(),
                                                  found.standard_error.tolist(), strict=True))]
    about = (f"kicked by {text.length_in_words(found.kick_height)} on a frictionless plate, "
             f"restitution {found.restitution:g}")
    lines = [f"{part.part_id}: {about}",
             f"{int(found.counts.sum())} flips, {int(found.unsettled.sum())} unsettled, seed "
             f"{found.seed}"] if not found.feeder_speed else [
        f"{part.part_id}: {several(found.observed, 'flip')} counted at speed "
        f"{found.feeder_speed}; the model's kick that explains them best:", about]
    lines += ["",
             "into pose, %; the error is the largest standard error of a row",
             *columns(heads, rows)]
    if ways:
        heads = [Column("parts that lie wrong are", left=True), Column("accepted a minute"),
                 Column("drops for each accepted"), Column("flips for each accepted")]
        lines += ["", *columns(heads, [
            [name.replace("_", " "), show_bounded(way.per_minute), show_bounded(way.passes),
             show_bounded(way.flips)] for name, way in ways.items()]),
            "in brackets: 90 % intervals, without the error of the plate"]
    return [*lines, *remarks(found.warnings, found.notes)]


def show_bounded(number: tuple[float, float, float]) -> str:
    """A number and its bounds."""
    value, low, high = number
    if math.isnan(value):
        return "-"
    if math.isnan(low) or math.isnan(high):
        return "no bound" if math.isinf(value) else three_digits(value)
    return f"{three_digits(value)} ({three_digits(low)} to {three_digits(high)})"


FLIPS_IN_ALL = 10_000  # with a kick, out of all poses, as a node answers

TIMES = {"pick-time": (1.0, "seconds to pick a part"),
         "camera-time": (0.2, "seconds of a picture"),
         "drop-time": (0.5, "seconds until dropped or kicked parts lie still")}


def register_feeding(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "feeding", help="plan a feeder cell: poses to pick and to flip, kick, parts on the plate",
        description="Plan a cell with a camera, a robot and a plate that kicks all parts on it "
        "together: which poses to pick, from which a kick is worth its time, which kick, how many "
        "parts to put on the plate, and how many are picked a minute, with an interval that has "
        "the plate's error in it.",
        examples=("ros_pose_stats feeding demo/clamp.stl --unit mm --wanted 0 1 "
                  "--plate 300mm 200mm --png kicks.png",), run=run_feeding)
    given.add_part(command, *given.POSES_OF, *given.SCENE)
    given.add(command, "--wanted", required=True)
    command.add_argument("--plate", nargs=2, type=given.read_length, required=True,
                         metavar=("L", "W"), help="sides of the area over which the centres of "
                         "the parts spread, as 0.3 (metres) or 300mm")
    command.add_argument("--clearance", type=given.read_length, default=0.0, metavar="C",
                         help="room that the gripper needs around a part, as 0.002 or 2mm "
                         "(default: 0)")
    given.add(command, "--rate", "--cycle-time")
    for name, (seconds, about) in TIMES.items():
        command.add_argument(f"--{name}", type=float, default=seconds, metavar="S",
                             help=f"{about} (default: %(default)s)")
    command.add_argument("--kicks", type=given.read_length, nargs="*", metavar="H",
                         help="kick heights that the plate can give, as 0.01 or 10mm (default: "
                         "thirteen from a twentieth of the part's radius to five radii)")
    add_counts_option(command)
    command.add_argument("--flips", type=given.read_count, metavar="N",
                         help=f"kicks out of each pose at each height (default: {FLIPS_IN_ALL} "
                         "shared out over the poses)")
    given.add(command, "--png", help="draw the parts a minute over the kick heights, as FILE.png")
    given.add(command, "--seed", "--workers", "--json")


def run_feeding(options: argparse.Namespace) -> int:
    """Estimate, kick from every height, plan and print."""
    picture = None if options.png is None else running.output_file(options.png, (".png",))
    if picture is not None and options.kicks == []:
        raise RequestError("--kicks with heights for --png", "none", "leave --kicks out for the "
                           "usual thirteen, or name some, for instance --kicks 5mm 10mm")
    if options.counts is not None and options.kicks == []:
        raise RequestError("kick heights beside --counts", "none", "leave --kicks out for the "
                           "usual thirteen: counted flips are learnt from those of the model")
    part = running.load_part_and_kernels(options)
    from ...planning.auto import estimate
    from ...simulation import flips as kicking, request as requests
    from ...statistics import feeding, feeding_plan, pose_groups

    cell = feeding_plan.FeederCell(
        options.rate, tuple(options.plate), options.clearance, options.cycle_time,
        options.pick_time, options.camera_time, options.drop_time)
    dropped = estimate(part, **given.scene_keywords(options))
    # What is refused is refused at once.
    plan = feeding_plan.plan_feeding(dropped, options.wanted, cell, part=part)
    counted = read_flips(options.counts, len(dropped.poses))
    kicks = kicking.usual_kicks(dropped.radius) if options.kicks is None else options.kicks
    warnings = [*dropped.warnings, *pose_groups.warn_of_alike(dropped, options.wanted),
                *scenes.height_warnings("kick", max(kicks, default=0.0), dropped.radius,
                                        scenes.HIGHEST_KICK)]
    each = max(1, FLIPS_IN_ALL // len(dropped.poses)) if options.flips is None else options.flips
    request = requests.drop_request(each, options.seed, 0.0, options.workers)
    with running.stop_on_interrupt() as interrupted, running.ProgressBar(sys.stderr) as bar:
        flips = kicking.flips_by_kick(
            part, given.scene_of(options), kicks, request, requests.Watch.of(None, interrupted),
            lambda done, total: bar.draw(done / total, f"kick {done + 1} of {total}"))
    stopped = interrupted()
    if counted and flips and not stopped:
        flips = [feeding.learn_flips(flips, each, speed) for speed, each in counted.items()]
    if flips:
        plan = feeding_plan.plan_feeding(dropped, options.wanted, cell, flips, part)
    if picture is not None and flips:
        from ...files import write_file
        from ...plots import figures, shares

        without, *kicked = plan.options
        write_file(picture, figures.figure_png(shares.kick_figure(
            part.part_id, cell.rate, cell.cycle_time, without.per_minute,
            [(kick.kick_height, kick.per_minute) for kick in kicked])))
    names = ("part_id", "part_digest", "method", "restitution", "drop_height",
             "cluster_tolerance", "round_sides", "plate_error", "version")
    return running.print_answer(
        options, lambda: {**{name: getattr(dropped, name) for name in names},
                          "wanted": options.wanted, "seed": request.seed, "flips": each,
                          "warnings": warnings, "notes": dropped.notes, **plan.as_dict()},
        lambda: _plan_lines(dropped, plan, cell, request.seed, warnings),
        f"interrupted after {len(flips)} of {len(set(kicks))} kick heights" if stopped else "")


def _plan_lines(dropped: "PoseStatistics", plan: "FeedingPlan", cell: "FeederCell", seed: int,
                warnings: list[str]) -> list[str]:
    """The plan for people."""
    from ...statistics.feeding_plan import FLIPS_ERROR, MOST_KICKS

    poses = {action: [index for index, each in enumerate(plan.actions) if each == action]
             for action in ("pick", "flip", "leave")}
    best = plan.best
    heads = [Column("kick height", "mm"), Column("parts on the plate"),
             Column("kicks until it is emptied"), Column("picked a minute"), Column("", left=True)]
    marks = ["best" if each is best else "as good, within its error"
             if each.per_minute.high >= best.per_minute.value else "" for each in plan.options]
    rows = [[text.millimetres(each.kick_height), str(each.parts),
             str(each.kicks) if each.kicks < MOST_KICKS else f"{MOST_KICKS} or more",
             show_bounded(each.per_minute), f"{each.feeder_speed} {mark}".strip()]
            for each, mark in zip(plan.options, marks, strict=True)]
    kick = (f"at speed {best.feeder_speed}" if best.feeder_speed else
            f"kicked by {text.length_in_words(best.kick_height)}" if best.kick_height else
            "not kicked")
    return [f"{dropped.part_id}: {show_bounded(best.per_minute)} picked a minute, {kick}",
            f"{dropped.scene}, method {dropped.method}",
            *(f"{action}: {text.listed(which)}" for action, which in poses.items() if which),
            f"{several(best.parts, 'part')} on a plate of "
            f"{' by '.join(map(text.millimetres, cell.plate))} mm; the first picture has "
            f"{best.pickable:.3g} to pick",
            "", *columns(heads, rows),
            f"in brackets: 90 % intervals, with {100.0 * dropped.plate_error:.2g} points of error "
            f"of the plate and {100.0 * FLIPS_ERROR:g} of flips that nobody counted; seed {seed}",
            *remarks(warnings, dropped.notes)]
