"""`compare A B...`: variants of a part side by side, and whether they differ."""

import argparse
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.errors import RequestError
from ...base.text import (
    Column,
    columns,
    interval,
    percent,
    points,
    ranges,
    remarks,
    several,
)
from ...core.records.scene import DEFAULT_PLATE_ERROR
from . import arguments as given, running

if TYPE_CHECKING:
    from ...core.records import Part
    from ..design.comparison import Comparison, VariantComparison

MOST_DROPS = 20_000


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "compare",
        help="set variants of a part side by side and say whether they differ",
        description="Drop variants of a part from the same starts, and say which feeds better, "
        "which of their poses correspond, and whether the drops show a difference in the model, "
        "and one to expect on a plate. Drops end where the verdict is settled or all differences "
        "are known to a point; as many afresh then give shares and differences.",
        examples=(
            "ros_pose_stats compare demo/clamp.stl demo/clamp.stl --unit mm "
            "--com 17mm 17mm 0 --com 17mm 17mm 2mm --wanted 0,1 -o clamps.html",
            "ros_pose_stats compare demo/prism.stl demo/cylinder.stl --unit mm --json",
        ),
        run=run,
    )
    command.add_argument(
        "parts",
        metavar="PART",
        nargs="+",
        help="files of two variants or more, the one to compare with first: "
        "STEP, STL, OBJ, PLY, OFF or 3MF",
    )
    given.add(command, "--unit", help=given.SHARED_UNIT)
    given.add(
        command,
        "--com",
        action="append",
        default=[],
        help=f"{given.CENTER}; once for all variants, or once for each in their order",
    )
    given.add(command, *given.POSES_OF, *given.SCENE)
    given.add(
        command,
        "--wanted",
        default=[],
        help="poses of the first variant that a feeder "
        "accepts, for instance 0 1 or 0-3: what it gets of each variant",
    )
    command.add_argument(
        "--plate-error",
        type=float,
        default=DEFAULT_PLATE_ERROR,
        metavar="E",
        help="error of a share on the real plate, as a fraction "
        "(default: %(default)s; a plate fitted to counts has its own)",
    )
    given.add(
        command,
        "--drops",
        default=MOST_DROPS,
        help="the most drops of each variant for "
        "the verdict (default: %(default)s); as many are made afresh",
    )
    given.add(command, "--seed", "--workers", "--json")
    given.add(
        command,
        "--output",
        help="write a page with pictures of the poses, too: FILE.html",
    )


def run(options: argparse.Namespace) -> int:
    """Compare, write the page, and print."""
    page = (
        None
        if options.output is None
        else running.output_file(options.output, (".html", ".htm"))
    )
    with running.preparing_kernels():
        from ..design.compare import compare

        parts = load_variants(options)
    with (
        running.stop_on_interrupt() as interrupted,
        running.ProgressBar(sys.stderr) as bar,
    ):
        found = compare(
            parts,
            options.wanted,
            options.drops,
            seed=options.seed,
            workers=options.workers,
            on_progress=lambda done, most: bar.draw(
                done / most, f"{done} of at most {most} drops"
            ),
            should_stop=interrupted,
            plate_error=options.plate_error,
            **given.scene_keywords(options),
        )
        stopped = interrupted()
    written = []
    if page is not None and found.drops:
        with running.end_on_interrupt():
            from ...base.files import write_file
            from ..report.page import comparison_page

            write_file(
                page,
                comparison_page(found, (command_to_reproduce(options, found),)).encode(
                    errors="replace"
                ),
            )
        written.append(f"{page}: {page.stat().st_size / 1e6:.2f} MB")
    return running.print_answer(
        options,
        found.as_dict,
        lambda: [*comparison_table(found), *written],
        f"interrupted after {found.drops} drops of each" if stopped else "",
    )


def load_variants(options: argparse.Namespace) -> "list[Part]":
    """Load the parts that the options name."""
    from ...core.mesh.parts import load_part

    centers = options.com or [None]
    if len(centers) not in (1, len(options.parts)):
        raise RequestError(
            f"--com once, or once for each of {len(options.parts)} variants",
            f"{len(centers)} times",
            "repeat it in the order of the files",
        )
    each = centers * len(options.parts) if len(centers) == 1 else centers
    paths = [Path(file) for file in options.parts]
    # Equal names are told apart by the whole paths.
    names = [
        path.stem
        if all(path.stem != other.stem for other in paths if other != path)
        else str(path)
        for path in paths
    ]
    return [
        load_part(file, options.unit, center, part_id=name, unless_declared=True)
        for file, center, name in zip(options.parts, each, names, strict=True)
    ]


def command_to_reproduce(options: argparse.Namespace, found: "Comparison") -> str:
    """The command that gives the same answer again."""
    words = ["ros_pose_stats", "compare", *options.parts, "--unit", options.unit]
    for center in options.com:
        words += given.typed_again({"com": center}, "com")
    return shlex.join(
        [
            *words,
            *given.typed_again(
                {**vars(options), "seed": found.seed},
                "cluster_tolerance",
                "round_sides",
                "restitution",
                "drop_height",
                "wanted",
                "plate_error",
                "drops",
                "seed",
            ),
        ]
    )


MOST_ROWS = 40


def comparison_table(found: "Comparison") -> list[str]:
    """Lines: the verdicts, then all variants beside the first one."""
    from ..design import describe

    lines = [describe.describe_verdict(found, one) for one in found.variants]
    lines += [
        "",
        *(
            f"{describe.letter(place)} {one.part_id}: "
            f"{several(len(one.poses), 'stable pose')}, radius {1e3 * one.radius:.4g} mm"
            for place, one in enumerate(found.found)
        ),
        found.found[0].scene,
        f"{found.drops} drops of each from the same starts, {found.found[0].unsettled} "
        f"unsettled, seed {found.seed}; as many before gave the verdicts",
    ]
    for one in found.variants:
        lines += ["", *_variant(one)]
    said = [
        [": ".join(one) for one in describe.name_remarks(found, kind)]
        for kind in ("warnings", "notes")
    ]
    return [
        *lines,
        *remarks(*said),
        "",
        "in brackets and as ranges: 90 % intervals, each by itself; verdicts hold for all "
        "poses together",
        f"computed in {found.seconds:.1f} s",
    ]


def _variant(one: "VariantComparison") -> list[str]:
    from ..design import describe

    other = describe.letter(one.second)
    heads = [
        Column("A"),
        Column(other),
        Column("A", "%"),
        Column("90 %", "%"),
        Column(other, "%"),
        Column("90 %", "%"),
        Column(f"{other} - A", "points"),
        Column("90 %", "points"),
        Column("difference", "in the model", left=True),
        Column("difference", "on a plate", left=True),
    ]
    rows = [
        [
            _numbers(pose.poses.first),
            _numbers(pose.poses.second),
            *_share(pose.share.first, pose.poses.first),
            *_share(pose.share.second, pose.poses.second),
            points(pose.share.difference.value, 2),
            f"{points(pose.share.difference.low, 2)} to {points(pose.share.difference.high, 2)}",
            pose.share.in_model.removeprefix("difference "),
            pose.share.on_plate.removeprefix("difference "),
        ]
        for pose in one.poses[:MOST_ROWS]
    ]
    lines = [*describe.describe_matching(one), *columns(heads, rows)]
    hidden = one.poses[MOST_ROWS:]
    if hidden:
        lines.append(f"... and {several(len(hidden), 'more row')}; --json lists all")
    if one.feeder is None:
        return lines
    heads = [
        Column("a feeder that accepts", left=True),
        Column("gets, %"),
        Column("drops for each accepted"),
    ]
    rows = [
        [
            f"{name} {_numbers(poses)}",
            f"{percent(share.value)} ({interval(share.low, share.high)})",
            "{:.4g} ({:.4g} - {:.4g})".format(*passes),
        ]
        for name, poses, share, passes in zip(
            ("A", other),
            one.feeder.poses,
            one.feeder.share[:2],
            one.feeder.passes,
            strict=True,
        )
    ]
    lost = one.feeder.lost
    return [
        *lines,
        "",
        *columns(heads, rows),
        *(
            [f"wanted poses of A without a partner in {other}: {ranges(lost)}"]
            if lost
            else []
        ),
    ]


def _numbers(poses: Sequence[int]) -> str:
    return ranges(poses) or "no partner"


def _share(share: tuple[float, float, float], poses: Sequence[int]) -> tuple[str, str]:
    value, low, high = share
    return (percent(value), interval(low, high)) if poses else ("-", "-")
