"""`flips PART`: where a kicked part comes to rest, and what kicking gains a feeder."""

import argparse
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from ...base.text import (
    Column,
    bounded,
    columns,
    length_in_words,
    percent,
    several,
)
from ...core.records.notes import note_paragraph
from ...core.records.scene import DEFAULT_DROPS
from .terminal import arguments, flip_counts, running

if TYPE_CHECKING:
    from ...core.records import FlipStatistics, Index, Part, PoseStatistics
    from ...core.simulation.request import DropRequest
    from ...core.statistics.feeding import Feeding

DEFAULT_FLIPS = 2000


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "flips",
        help="kick a part out of each of its poses and count where it comes to rest",
        description="Kick a part, lying in each of its poses, from below at a point of "
        "its contact polygon, and count where it comes to rest. With the wanted poses "
        "it says what a feeder gets by kicking parts that lie wrong, and by dropping "
        "them again; `feeding` finds the kick that feeds fastest. With flips that a "
        "cell has counted it gives the matrix of each of the feeder's settings: what "
        "was counted, with the model's kick that explains it best where little was.",
        examples=(
            "ros_pose_stats flips demo/clamp.stl --unit mm --kick 0.02 --wanted 0 1",
        ),
        run=run,
    )
    arguments.add_part(command, *arguments.POSE_OPTIONS)
    kicks = command.add_mutually_exclusive_group(required=True)
    kicks.add_argument("--kick", **arguments.OPTIONS["--kick"])
    flip_counts.add_counts_option(kicks)
    command.add_argument(
        "--flips",
        type=arguments.read_count,
        metavar="N",
        default=DEFAULT_FLIPS,
        help="kicks out of each pose, with --counts at each of thirteen heights "
        "(default: %(default)s)",
    )
    arguments.add_options(
        command,
        "--drops",
        default=DEFAULT_DROPS,
        help="drops for the poses of parts that are dropped (default: %(default)s)",
    )
    arguments.add_options(
        command,
        *arguments.SCENE_OPTIONS,
        "--wanted",
        "--rate",
        "--cycle-time",
        "--seed",
        "--workers",
        "--json",
    )


def run(options: argparse.Namespace) -> int:
    """Kick, drop where poses are wanted, and print."""
    part = running.load_part_and_kernels(options)
    from ...core.resting.poses import poses_in
    from ...core.simulation import request, simulate
    from ...core.statistics import feeding

    resting_poses = poses_in(part, arguments.drop_scene(options))
    pose_count = len(resting_poses.poses)
    counted_flips = flip_counts.read_flips(options.counts, pose_count)
    # What is refused is refused at once.
    request.drop_request(options.drops, options.seed)
    if options.wanted is not None:
        feeding.check_wanted_poses(options.wanted, pose_count)
        feeding.check_rate(options.rate, options.cycle_time)
    flip_request = request.drop_request(
        options.flips, options.seed, 0.0, options.workers
    )
    drops = None
    with running.stop_on_interrupt() as is_interrupted, running.ProgressBar() as bar:
        radius = resting_poses.body.radius
        flips = kick_part(
            part, radius, counted_flips, flip_request, is_interrupted, bar, options
        )
        if options.wanted is not None and not is_interrupted():
            drops = simulate.simulate(
                part,
                options.drops,
                seed=flip_request.seed,
                workers=options.workers,
                on_progress=bar.show,
                should_stop=is_interrupted,
                **arguments.scene_keywords(options),
            )
    interruption = ""
    if is_interrupted():
        flip_count = sum(statistics.flips for statistics in flips)
        interruption = f"interrupted after {flip_count} flips"
    settings = []
    tables = []
    for statistics in flips:
        statistics = with_warnings(statistics, drops, options)
        feedings: dict[str, Feeding] = {}
        if drops is not None and not interruption:
            feedings = feed(drops, statistics, options)
        values = statistics.as_dict()
        if feedings:
            values["feeding"] = feedings
        settings.append(values)
        tables.append("\n".join(flips_table(part, statistics, feedings)))
    return running.print_answer(
        options,
        {"settings": settings} if options.counts else settings[0],
        ["\n\n".join(tables)],
        interruption,
    )


def kick_part(
    part: "Part",
    radius: float,
    counted_flips: "dict[str, Index]",
    flip_request: "DropRequest",
    should_stop: "Callable[[], bool]",
    bar: running.ProgressBar,
    options: argparse.Namespace,
) -> "list[FlipStatistics]":
    """Flips by the kick of the options, or what explains the counts of each setting."""
    from ...core.simulation import flips, request

    if not counted_flips:
        statistics = flips.count_flips(
            part,
            arguments.drop_scene(options),
            options.kick,
            flip_request,
            request.Watch(should_stop=should_stop),
            lambda count, total: bar.draw(count / total, f"{count} of {total} flips"),
        )
        return [statistics]
    simulated_flips = flip_counts.kick_from_heights(
        part, flips.usual_kicks(radius), flip_request, should_stop, bar, options
    )
    if should_stop():
        return []
    return flip_counts.learn_settings(simulated_flips, counted_flips)


def with_warnings(
    flips: "FlipStatistics",
    drops: "PoseStatistics | None",
    options: argparse.Namespace,
) -> "FlipStatistics":
    """The flips with the warnings of the drops, if there were any, each once."""
    from ...core.statistics.pose_groups import warn_of_lookalikes

    warnings = list(flips.warnings)
    if drops is not None:
        warnings += [*drops.warnings, *warn_of_lookalikes(drops, options.wanted)]
    return replace(flips, warnings=tuple(dict.fromkeys(warnings)))


def feed(
    drops: "PoseStatistics", flips: "FlipStatistics", options: argparse.Namespace
) -> "dict[str, Feeding]":
    """What a feeder gets that drops parts again that lie wrong, or kicks them."""
    from ...core.statistics import feeding, pose_groups

    shares = pose_groups.pose_shares(drops)
    return {
        "dropped_again": feeding.drop_afresh(shares, options.wanted, options.rate),
        "kicked": feeding.flip_wrong_poses(
            shares,
            flips.effective_counts,
            options.wanted,
            options.rate,
            options.cycle_time,
        ),
    }


def flips_table(
    part: "Part", flips: "FlipStatistics", feedings: "dict[str, Feeding]"
) -> list[str]:
    """Lines: the kick, shares of poses out of each pose, and what a feeder gets."""
    heads = [
        Column("out of"),
        *(Column(f"{pose.index}") for pose in flips.poses),
        Column("error"),
    ]
    rows = [
        [str(i), *(percent(share) for share in shares), percent(max(errors))]
        for i, (shares, errors) in enumerate(
            zip(flips.transition.tolist(), flips.standard_error.tolist(), strict=True)
        )
    ]
    lines = [
        *describe_flips(part, flips),
        "",
        "into pose, %; the error is the largest standard error of a row",
        *columns(heads, rows),
    ]
    if feedings:
        lines += ["", *feedings_table(feedings)]
    return [*lines, *note_paragraph(flips.warnings)]


def describe_flips(part: "Part", flips: "FlipStatistics") -> list[str]:
    """How the part was kicked, and how often, or which counts the kick explains."""
    kick = (
        f"kicked by {length_in_words(flips.kick_height)} on a frictionless plate, "
        f"restitution {flips.restitution:g}"
    )
    if flips.feeder_setting:
        return [
            f"{part.part_id}: {several(flips.counted_flips, 'flip')} counted at "
            f"setting {flips.feeder_setting}; the model's kick that explains them "
            "best:",
            kick,
        ]
    return [
        f"{part.part_id}: {kick}",
        f"{int(flips.counts.sum())} flips, {int(flips.unsettled.sum())} unsettled, "
        f"seed {flips.seed}",
    ]


def feedings_table(feedings: "dict[str, Feeding]") -> list[str]:
    """Lines: what a feeder gets by each way to treat parts that lie wrong."""
    heads = [
        Column("parts that lie wrong are", left=True),
        Column("accepted a minute"),
        Column("drops for each accepted"),
        Column("flips for each accepted"),
    ]
    rows = [
        [
            name.replace("_", " "),
            bounded(feeding.per_minute),
            bounded(feeding.passes),
            bounded(feeding.flips),
        ]
        for name, feeding in feedings.items()
    ]
    return [
        *columns(heads, rows),
        "in brackets: 90 % intervals, without the error of the plate",
    ]
