# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""`compare A B...`: variants of a part side by side, and whether they differ."""

import argparse
import shlex
from collections import Counter
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
    printable,
    ranges,
    several,
)
from ...core.records.notes import note_paragraph
from ...core.records.scene import DEFAULT_PLATE_ERROR
from .terminal import arguments, running

if TYPE_CHECKING:
    from ...core.records import Part
    from ..design.comparison import (
        Comparison,
        FeederComparison,
        PoseComparison,
        VariantComparison,
    )

MOST_DROPS = 20_000


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "compare",
        help="set variants of a part side by side and say whether they differ",
        description="Drop variants of a part from the same starts, and say which feeds "
        "better, which of their poses correspond, and whether the drops show a "
        "difference in the model, and one to expect on a plate. Drops end where the "
        "verdict is settled or all differences are known to a point; as many afresh "
        "then give shares and differences.",
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
    arguments.add_options(command, "--unit", help=arguments.SHARED_UNIT_HELP)
    arguments.add_options(command, "--body")
    arguments.add_options(
        command,
        "--com",
        action="append",
        default=[],
        help=f"{arguments.CENTER_HELP}; once for all variants, or once for each in "
        "their order",
    )
    arguments.add_options(command, *arguments.POSE_OPTIONS, *arguments.SCENE_OPTIONS)
    arguments.add_options(
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
    arguments.add_options(
        command,
        "--drops",
        default=MOST_DROPS,
        help="the most drops of each variant for "
        "the verdict (default: %(default)s); as many are made afresh",
    )
    arguments.add_options(command, "--seed", "--workers", "--json")
    arguments.add_options(
        command,
        "--output",
        help="write a page with pictures of the poses, too: FILE.html",
    )


def run(options: argparse.Namespace) -> int:
    """Compare, write the page, and print."""
    page = None if options.output is None else running.page_file(options.output)
    with running.preparing_kernels():
        from ..design.compare import compare

        parts = load_variants(options)
    with (
        running.stop_on_interrupt() as is_interrupted,
        running.ProgressBar() as bar,
    ):
        comparison = compare(
            parts,
            options.wanted,
            options.drops,
            seed=options.seed,
            workers=options.workers,
            on_progress=lambda drops, bound: bar.draw(
                drops / bound, f"{drops} of at most {bound} drops"
            ),
            should_stop=is_interrupted,
            plate_error=options.plate_error,
            **arguments.scene_keywords(options),
        )
        interruption = ""
        if is_interrupted():
            interruption = f"interrupted after {comparison.drops} drops of each"
    pages = []
    if page is not None and comparison.drops:
        with running.end_on_interrupt():
            write_page(page, comparison, options)
        pages.append(running.describe_size(page))
    lines = [*comparison_table(comparison), *pages]
    return running.print_answer(options, comparison.as_dict(), lines, interruption)


def write_page(
    page: Path, comparison: "Comparison", options: argparse.Namespace
) -> None:
    """Write the page with pictures of the poses."""
    from ...base.files import write_file
    from ..report.page import comparison_page

    text = comparison_page(comparison, (command_to_reproduce(options, comparison),))
    write_file(page, text.encode(errors="replace"))


def load_variants(options: argparse.Namespace) -> "list[Part]":
    """Load the parts that the options name."""
    from ...core.mesh.parts import load_part

    centers = options.com or [None]
    if len(centers) == 1:
        centers *= len(options.parts)
    if len(centers) != len(options.parts):
        raise RequestError(
            f"--com once, or once for each of {len(options.parts)} variants",
            f"{len(centers)} times",
            "repeat it in the order of the files",
        )
    paths = [Path(file) for file in options.parts]
    stems = Counter(path.stem for path in set(paths))
    return [
        load_part(
            file,
            options.unit,
            center,
            # Parts of equal names go by their whole paths.
            part_id=printable(path.stem if stems[path.stem] == 1 else str(path)),
            unless_declared=True,
            body=options.body,
        )
        for file, path, center in zip(options.parts, paths, centers, strict=True)
    ]


def command_to_reproduce(options: argparse.Namespace, comparison: "Comparison") -> str:
    """The command that gives the same answer again."""
    words = ["ros_pose_stats", "compare", *options.parts, "--unit", options.unit]
    words += arguments.option_words(vars(options), "body")
    for center in options.com:
        words += arguments.option_words({"com": center}, "com")
    words += arguments.option_words(
        {**vars(options), "seed": comparison.seed},
        *arguments.SCENE_NAMES,
        "wanted",
        "plate_error",
        "drops",
        "seed",
    )
    return shlex.join(words)


MOST_ROWS = 40


def comparison_table(comparison: "Comparison") -> list[str]:
    """Lines: the verdicts, then all variants beside the first one."""
    from ..design import describe

    statistics = comparison.statistics
    lines = [
        *(
            describe.describe_verdict(comparison, variant)
            for variant in comparison.variants
        ),
        "",
        *(
            f"{describe.letter(k)} {variant.part_id}: "
            f"{several(len(variant.poses), 'stable pose')}, "
            f"radius {1e3 * variant.radius:.4g} mm"
            for k, variant in enumerate(statistics)
        ),
        statistics[0].scene,
        f"{comparison.drops} drops of each from the same starts, "
        f"{statistics[0].unsettled} unsettled, seed {comparison.seed}; as many before "
        "gave the verdicts",
    ]
    for variant in comparison.variants:
        lines += ["", *variant_table(variant)]
    warnings = [  # each sentence begins with the variants that it is about
        warning._replace(text=f"{letters}: {warning.text}")
        for letters, warning in describe.name_warnings(comparison)
    ]
    return [
        *lines,
        *note_paragraph(warnings),
        "",
        "in brackets and as ranges: 90 % intervals, each by itself; verdicts hold for "
        "all poses together",
        f"computed in {comparison.seconds:.1f} s",
    ]


def variant_table(variant: "VariantComparison") -> list[str]:
    """Lines: poses of a variant beside those of the first, and what a feeder gets."""
    from ..design import describe

    letter = describe.letter(variant.second)
    heads = [
        Column("A"),
        Column(letter),
        Column("A", "%"),
        Column("90 %", "%"),
        Column(letter, "%"),
        Column("90 %", "%"),
        Column(f"{letter} - A", "points"),
        Column("90 %", "points"),
        Column("difference", "in the model", left=True),
        Column("difference", "on a plate", left=True),
    ]
    rows = [pose_cells(pose) for pose in variant.poses[:MOST_ROWS]]
    lines = [*describe.describe_matching(variant), *columns(heads, rows)]
    hidden = variant.poses[MOST_ROWS:]
    if hidden:
        lines.append(f"... and {several(len(hidden), 'more row')}; --json lists all")
    if variant.feeder is not None:
        lines += ["", *feeder_table(variant.feeder, letter)]
    return lines


def pose_cells(pose: "PoseComparison") -> list[str]:
    """The cells of a row: corresponding poses, their shares, and the difference."""
    share = pose.share
    difference = share.difference
    return [
        pose_numbers(pose.poses.first),
        pose_numbers(pose.poses.second),
        *share_cells(share.first, pose.poses.first),
        *share_cells(share.second, pose.poses.second),
        points(difference.value, 2),
        f"{points(difference.low, 2)} to {points(difference.high, 2)}",
        share.in_model.removeprefix("difference "),
        share.on_plate.removeprefix("difference "),
    ]


def feeder_table(feeder: "FeederComparison", letter: str) -> list[str]:
    """Lines: what a feeder gets of the first variant and of another."""
    heads = [
        Column("a feeder that accepts", left=True),
        Column("gets, %"),
        Column("drops for each accepted"),
    ]
    rows = [
        [
            f"{name} {pose_numbers(poses)}",
            f"{percent(share.value)} ({interval(share.low, share.high)})",
            "{:.4g} ({:.4g} - {:.4g})".format(*passes),
        ]
        for name, poses, share, passes in zip(
            ("A", letter),
            feeder.poses,
            feeder.share[:2],
            feeder.passes,
            strict=True,
        )
    ]
    lines = columns(heads, rows)
    if feeder.lost:
        lines.append(
            f"wanted poses of A without a partner in {letter}: {ranges(feeder.lost)}"
        )
    return lines


def pose_numbers(poses: Sequence[int]) -> str:
    """Numbers of poses that correspond to some of the other variant."""
    return ranges(poses) or "no partner"


def share_cells(
    share: tuple[float, float, float], poses: Sequence[int]
) -> tuple[str, str]:
    """A share and its interval; dashes where there is no pose."""
    if not poses:
        return "-", "-"
    value, low, high = share
    return percent(value), interval(low, high)
