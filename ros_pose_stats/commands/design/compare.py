"""`compare A B...`: variants of a part side by side, and whether they differ."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import RequestError
from ...records.scene import DEFAULT_PLATE_ERROR
from ..arguments import (
    JoinIndices,
    add_pose_options,
    add_scene_options,
    add_shared_unit_option,
    read_count,
    read_indices,
)
from ..progress_bar import ProgressBar
from ..running import (
    INTERRUPTED,
    announce_slow_start,
    end_on_interrupt,
    output_file,
    print_json,
    stop_on_interrupt,
)

if TYPE_CHECKING:
    from ...design.comparison import Comparison
    from ...records import Part

MOST_DROPS = 20_000


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command."""
    command = commands.add_parser(
        "compare", help="set variants of a part side by side and say whether they differ",
        description="Drop variants of a part from the same starts, and say which of their poses "
        "correspond, how their shares differ from those of the first one, and whether the "
        "drops show a difference in the model, and one to expect on a plate. It ends where the "
        "verdict is settled or all differences are known to a point.",
        examples=("ros_pose_stats compare demo/clamp.stl demo/clamp.stl --unit mm "
                  "--com 17 17 0 --com 17 17 2 --wanted 0,1 -o clamps.html",
                  "ros_pose_stats compare demo/prism.stl demo/cylinder.stl --unit mm --json"))
    command.add_argument("parts", metavar="PART", nargs="+",
                         help="files of two variants or more, the one to compare with first: "
                         "STEP, STL, OBJ, PLY, OFF or 3MF")
    add_shared_unit_option(command)
    command.add_argument("--com", nargs=3, type=float, action="append", default=[],
                         metavar=("X", "Y", "Z"),
                         help="centre of mass in the file's unit (default: uniform density); "
                         "once for all variants, or once for each in their order")
    add_pose_options(command)
    add_scene_options(command)
    command.add_argument("--wanted", type=read_indices, nargs="+", action=JoinIndices,
                         default=[], metavar="I",
                         help="poses of the first variant that a feeder accepts, for instance 0 1 "
                         "or 0-3: what it gets of each variant")
    command.add_argument("--plate-error", type=float, default=DEFAULT_PLATE_ERROR, metavar="E",
                         help="error of a share on the real plate, as a fraction "
                         "(default: %(default)s; a plate fitted to counts has its own)")
    command.add_argument("--drops", type=read_count, default=MOST_DROPS, metavar="N",
                         help="the most drops of each variant (default: %(default)s)")
    command.add_argument("--seed", type=read_count, metavar="S",
                         help="the same seed gives the same answer (default: a fresh one, which "
                         "is printed)")
    command.add_argument("--workers", type=read_count, metavar="W",
                         help="number of threads (default: all cores)")
    command.add_argument("-o", "--output", metavar="FILE",
                         help="write a page with pictures of the poses, too: FILE.html")
    command.add_argument("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Compare, write the page, and print."""
    page = None if options.output is None else output_file(options.output, (".html", ".htm"))
    with announce_slow_start(), end_on_interrupt():
        from ...design.compare import compare
        from ...kernels.compilation import prepare_kernels

        parts = load_variants(options)
        prepare_kernels()
    with stop_on_interrupt() as interrupted, ProgressBar(sys.stderr) as bar:
        found = compare(
            parts, options.wanted, options.drops, options.restitution, options.seed,
            options.drop_height, options.workers,
            lambda done, most: bar.draw(done / most, f"{done} of at most {most} drops"),
            interrupted, cluster_tolerance=options.cluster_tolerance,
            round_sides=options.round_sides, plate_error=options.plate_error)
        stopped = interrupted()
    if page is not None and found.drops:
        with end_on_interrupt():
            from ...files import write_file
            from ...report.comparison_page import comparison_page

            write_file(page, comparison_page(found, (command_to_reproduce(options, found),)
                                             ).encode())
    if options.json:
        print_json({**found.as_dict(), **({"interrupted": True} if stopped else {})})
    else:
        from .comparison_table import comparison_table

        print(comparison_table(found))
        if page is not None and found.drops:
            print(f"{page}: {page.stat().st_size / 1e6:.2f} MB")
        if stopped:
            print(f"interrupted after {found.drops} drops of each")
    return INTERRUPTED if stopped else 0


def load_variants(options: argparse.Namespace) -> list[Part]:
    """Load the parts that the options name.

    Raises RequestError if centres of mass are given for some of them only.
    """
    from ...mesh.parts import load_part

    centers = options.com or [None]
    if len(centers) not in (1, len(options.parts)):
        raise RequestError(f"--com once, or once for each of {len(options.parts)} variants",
                           f"{len(centers)} times", "repeat it in the order of the files")
    each = centers * len(options.parts) if len(centers) == 1 else centers
    return [load_part(file, options.unit, center, part_id=name, center_in_unit=True,
                      unless_declared=True)
            for file, center, name in zip(options.parts, each, name_variants(options.parts),
                                          strict=True)]


def name_variants(files: Sequence[str]) -> list[str]:
    """Names of files, with as much of their folders as tells different ones apart."""
    paths = [Path(file) for file in files]
    return [_name_apart(path, [other for other in paths if other != path]) for path in paths]


def _name_apart(path: Path, others: Sequence[Path]) -> str:
    if path.stem not in {other.stem for other in others}:
        return path.stem
    if path.with_suffix("") in {other.with_suffix("") for other in others}:
        return str(path)
    parts = path.with_suffix("").parts
    for kept in range(2, len(parts) + 1):
        if parts[-kept:] not in {other.with_suffix("").parts[-kept:] for other in others}:
            return str(Path(*parts[-kept:]))
    return f"./{path.with_suffix('')}"


def command_to_reproduce(options: argparse.Namespace, found: Comparison) -> str:
    """The command that gives the same answer again."""
    words = ["ros_pose_stats", "compare", *options.parts]
    if options.unit is not None:
        words += ["--unit", options.unit]
    for center in options.com:
        words += ["--com", *(repr(x) for x in center)]
    words += ["--cluster-tolerance", repr(options.cluster_tolerance),
              "--round-sides", str(options.round_sides),
              "--restitution", repr(options.restitution)]
    if options.drop_height is not None:
        words += ["--drop-height", repr(options.drop_height)]
    words += ["--wanted", *map(str, options.wanted)] if options.wanted else []
    return shlex.join([*words, "--plate-error", repr(options.plate_error),
                       "--drops", str(options.drops), "--seed", str(found.seed)])
