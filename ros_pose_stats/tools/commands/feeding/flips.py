"""`flips PART`: where a kicked part comes to rest, and what kicking gains a feeder."""

import argparse
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ....base.errors import RequestError
from ....base.text import (
    Column,
    columns,
    length_in_words,
    percent,
    remarks,
    several,
    three_digits,
)
from ....core.records.scene import DEFAULT_DROPS
from .. import arguments as given, running

if TYPE_CHECKING:
    from ....core.records import FlipStatistics, Index, Part
    from ....core.statistics.feeding import Feeding

DEFAULT_FLIPS = 2000


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "flips",
        help="kick a part out of each of its poses and count where it comes to rest",
        description="Kick a part, lying in each of its poses, from below at a point of its "
        "contact polygon, and count where it comes to rest. With the wanted poses it says what "
        "a feeder gets by kicking parts that lie wrong, and by dropping them again; `feeding` "
        "finds the kick that feeds fastest. With flips that a cell has counted it gives the "
        "matrix of each of the feeder's speeds: what was counted, with the model's kick that "
        "explains it best where little was.",
        examples=(
            "ros_pose_stats flips demo/clamp.stl --unit mm --kick 0.02 --wanted 0 1",
        ),
        run=run,
    )
    given.add_part(command, *given.POSES_OF)
    kicks = command.add_mutually_exclusive_group(required=True)
    kicks.add_argument("--kick", **given.OPTIONS["--kick"])
    add_counts_option(kicks)
    command.add_argument(
        "--flips",
        type=given.read_count,
        metavar="N",
        default=DEFAULT_FLIPS,
        help="kicks out of each pose, with --counts at each of thirteen heights "
        "(default: %(default)s)",
    )
    given.add(
        command,
        "--drops",
        default=DEFAULT_DROPS,
        help="drops for the poses of parts that are dropped (default: %(default)s)",
    )
    given.add(
        command,
        *given.SCENE,
        "--wanted",
        "--rate",
        "--cycle-time",
        "--seed",
        "--workers",
        "--json",
    )


def add_counts_option(command: argparse._ActionsContainer) -> None:
    """Add `--counts`."""
    command.add_argument(
        "--counts",
        metavar="FILE",
        help="CSV file of flips that were counted, "
        "with the columns speed (its name), from and to (index of a pose), count",
    )


def read_flips(file: str | None, poses: int) -> "dict[str, Index]":
    """Flips (K, K) from pose to pose by the feeder's speed; of no file, none."""
    import numpy as np

    from ....core.plates.counts import read_table

    found: dict[str, Index] = {}
    rows = (
        []
        if file is None
        else read_table(Path(file), "speed, from, to, count", "slow,3,0,41")
    )
    for speed, (before, after, count) in rows:
        if max(before, after) >= poses:
            raise RequestError(
                f"poses 0 to {poses - 1}",
                f"{max(before, after)} in {file}",
                "count with the numbers that estimate shows",
            )
        found.setdefault(speed, np.zeros((poses, poses), np.int64))[before, after] += (
            count
        )
    if none := [speed for speed, counts in found.items() if not counts.any()]:
        raise RequestError(
            "flips at every speed",
            f"none at {none[0]} in {file}",
            "count some, or leave the speed out",
        )
    return found


def run(options: argparse.Namespace) -> int:
    """Kick, drop where poses are wanted, and print."""
    part = running.load_part_and_kernels(options)
    from ....core.resting.poses import poses_in
    from ....core.simulation import flips, request as requests, simulate
    from ....core.statistics import feeding, pose_groups

    scene = given.scene_of(options)
    fresh = None
    resting = poses_in(part, scene)
    counted = read_flips(options.counts, len(resting.poses))
    requests.drop_request(options.drops, options.seed)
    if options.wanted is not None:
        feeding.check_wanted(options.wanted, len(resting.poses))
        feeding.check_rate(options.rate, options.cycle_time)
    request = requests.drop_request(options.flips, options.seed, 0.0, options.workers)
    with (
        running.stop_on_interrupt() as interrupted,
        running.ProgressBar(sys.stderr) as bar,
    ):
        watch = requests.Watch.of(None, interrupted)
        if counted:
            kicks = flips.flips_by_kick(
                part,
                scene,
                flips.usual_kicks(resting.body.radius),
                request,
                watch,
                lambda done, total: bar.draw(
                    done / total, f"kick {done + 1} of {total}"
                ),
            )
            found = (
                []
                if interrupted()
                else [
                    feeding.learn_flips(kicks, each, speed)
                    for speed, each in counted.items()
                ]
            )
        else:
            found = [
                flips.count_flips(
                    part,
                    scene,
                    options.kick,
                    request,
                    watch,
                    lambda done, total: bar.draw(
                        done / total, f"{done} of {total} flips"
                    ),
                )
            ]
        if options.wanted is not None and not interrupted():
            fresh = simulate.simulate(
                part,
                options.drops,
                seed=request.seed,
                workers=options.workers,
                on_progress=bar.show,
                should_stop=interrupted,
                **given.scene_keywords(options),
            )
    stopped = interrupted()
    speeds = []
    tables = []
    dropped = None if fresh is None or stopped else pose_groups.pose_shares(fresh)
    warnings = (
        []
        if fresh is None
        else [*fresh.warnings, *pose_groups.warn_of_alike(fresh, options.wanted)]
    )
    for each in found:
        each = replace(each, warnings=tuple(dict.fromkeys((*each.warnings, *warnings))))
        ways = (
            {}
            if dropped is None
            else {
                "dropped_again": feeding.drop_afresh(
                    dropped, options.wanted, options.rate
                ),
                "kicked": feeding.flip_wrong_ones(
                    dropped,
                    each.counts,
                    options.wanted,
                    options.rate,
                    options.cycle_time,
                ),
            }
        )
        speeds.append({**each.as_dict(), **({"feeding": ways} if ways else {})})
        tables.append("\n".join(_table(part, each, ways)))
    return running.print_answer(
        options,
        lambda: {"speeds": speeds} if options.counts else speeds[0],
        lambda: ["\n\n".join(tables)],
        f"interrupted after {sum(each.flips for each in found)} flips"
        if stopped
        else "",
    )


def _table(
    part: "Part", found: "FlipStatistics", ways: "dict[str, Feeding]"
) -> list[str]:
    heads = [
        Column("out of"),
        *(Column(f"{pose.index}") for pose in found.poses),
        Column("error"),
    ]
    rows = [
        [str(i), *(percent(share) for share in row), percent(float(max(errors)))]
        for i, (row, errors) in enumerate(
            zip(found.transition.tolist(), found.standard_error.tolist(), strict=True)
        )
    ]
    about = (
        f"kicked by {length_in_words(found.kick_height)} on a frictionless plate, "
        f"restitution {found.restitution:g}"
    )
    lines = (
        [
            f"{part.part_id}: {about}",
            f"{int(found.counts.sum())} flips, {int(found.unsettled.sum())} unsettled, seed "
            f"{found.seed}",
        ]
        if not found.feeder_speed
        else [
            f"{part.part_id}: {several(found.observed, 'flip')} counted at speed "
            f"{found.feeder_speed}; the model's kick that explains them best:",
            about,
        ]
    )
    lines += [
        "",
        "into pose, %; the error is the largest standard error of a row",
        *columns(heads, rows),
    ]
    if ways:
        heads = [
            Column("parts that lie wrong are", left=True),
            Column("accepted a minute"),
            Column("drops for each accepted"),
            Column("flips for each accepted"),
        ]
        lines += [
            "",
            *columns(
                heads,
                [
                    [
                        name.replace("_", " "),
                        show_bounded(way.per_minute),
                        show_bounded(way.passes),
                        show_bounded(way.flips),
                    ]
                    for name, way in ways.items()
                ],
            ),
            "in brackets: 90 % intervals, without the error of the plate",
        ]
    return [*lines, *remarks(found.warnings, found.notes)]


def show_bounded(number: tuple[float, float, float]) -> str:
    """A number and its bounds."""
    value, low, high = number
    if math.isnan(value):
        return "-"
    if math.isnan(low) or math.isnan(high):
        return "no bound" if math.isinf(value) else three_digits(value)
    return f"{three_digits(value)} ({three_digits(low)} to {three_digits(high)})"
