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

"""`fit COUNTS...`: restitution and drop height that stand for a plate, from counts."""

import argparse
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.text import (
    Column,
    columns,
    length_in_words,
    listed,
    percent,
    printable,
    several,
)
from ...core.records.scene import DEFAULT_DROP_RADII
from .terminal import arguments, running

if TYPE_CHECKING:
    from ...core.plates import CountedPart, PlateFit, PlateProfile


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "fit",
        help="fit a plate's restitution and drop height to what was counted on it",
        description="Find the restitution and the drop height at which the model "
        "explains best what was counted on a plate, say how far to trust them, and "
        "write them into a file of plates.",
        examples=(
            "ros_pose_stats fit counts.csv --unit mm --plate glass",
            "ros_pose_stats fit ~/.ros/pose_stats --plate glass --plates "
            "cell/plates.yaml",
        ),
        run=run,
    )
    command.add_argument(
        "counts",
        metavar="COUNTS",
        nargs="+",
        help="CSV file with the columns part (its file), pose (index) and count; "
        "or bag directory, directory of many bags, or single bag file",
    )
    command.add_argument(
        "--plate",
        required=True,
        metavar="NAME",
        help="name of the plate; of counts in bags that name a plate, only its "
        "own are used",
    )
    command.add_argument(
        "--plates",
        default="plates.yaml",
        metavar="FILE",
        help="file of plates to write the plate into; its other plates stay "
        "(default: %(default)s)",
    )
    arguments.add_options(command, "--unit", help=arguments.SHARED_UNIT_HELP)
    arguments.add_options(
        command,
        *arguments.POSE_OPTIONS,
        help="with which the poses in the CSV are numbered (default: %(default)s)",
    )
    arguments.add_options(command, "--json")


def run(options: argparse.Namespace) -> int:
    """Fit, write the plate and print."""
    with running.preparing_kernels():
        from ...base.files import refuse_unwritable
        from ...core.plates import fit, profile

        file = Path(options.plates)
        profile.refuse_name(options.plate)
        refuse_unwritable(file.parent)
        profile.refuse_foreign(file)
        counted_parts, notes = read_counts(options)
    with running.end_on_interrupt():
        plate_fit = fit.fit_plate(counted_parts)
    fitted_digests = {part.part_digest for part in plate_fit.parts}
    unused_parts = {
        counted.part.part_id: None
        for counted in counted_parts
        if counted.part.digest not in fitted_digests
    }
    if unused_parts:
        notes.append(
            f"not in the fit: {listed(list(unused_parts))}; it takes the "
            f"{fit.MOST_PARTS} parts counted most of those that can lie in two ways"
        )
    for note in notes:
        print(f"ros_pose_stats: {printable(note)}", file=sys.stderr)
    plate = profile.profile_of(options.plate, plate_fit)
    profile.write_profile(file, plate)
    if options.json:
        print_json(plate, file, plate_fit, notes)
    else:
        lines = [
            *plate_table(plate, plate_fit),
            "",
            f"wrote {file}",
            *plate_fit.verdict.split("; "),
        ]
        print(*map(printable, lines), sep="\n")  # bags and tables name the parts
    return 0


def print_json(
    plate: "PlateProfile", file: Path, plate_fit: "PlateFit", notes: list[str]
) -> None:
    """Print the plate, and what was counted and expected of each part."""
    running.print_json(
        {
            "plate": plate.name,
            **plate.as_dict(),
            "file": str(file),
            "seconds": plate_fit.seconds,
            "use": plate_fit.is_better,
            "stands_out": None
            if plate_fit.strange_part is None
            else plate_fit.strange_part.part_id,
            "verdict": plate_fit.verdict,
            "default_error": plate_fit.default_error,
            "evidence": [
                {
                    "part_id": part.part_id,
                    "part_digest": part.part_digest,
                    "counted": part.total,
                    "groups": [
                        {"poses": poses, "observed": observed, "expected": expected}
                        for poses, observed, expected in zip(
                            part.poses, part.observed, part.expected, strict=True
                        )
                    ],
                    "error": part.error,
                    "left_out_error": part.left_out_error,
                    "default_error": part.default_error,
                    "chance": part.chance,
                }
                for part in plate_fit.parts
            ],
            "notes": notes,
        }
    )


def read_counts(options: argparse.Namespace) -> "tuple[list[CountedPart], list[str]]":
    """Counts in tables and bags, and notes on what could not be used."""
    from ...core.plates import read_counted_parts

    tables, bags = arguments.split_tables(options.counts)
    counted_parts = [
        counted_part
        for table in tables
        for counted_part in read_counted_parts(
            table,
            options.unit,
            cluster_tolerance=options.cluster_tolerance,
            round_sides=options.round_sides,
        )
    ]
    notes = [
        f"{counted.part.part_id}: {warning}"
        for counted in counted_parts
        for warning in counted.part.warnings
    ]
    if bags:
        from ..bags.plate_counts import counts_on_plate

        with running.ProgressBar() as bar:
            recorded_parts, refused_counts = counts_on_plate(
                bags, options.plate, bar.show_bytes
            )
        counted_parts += recorded_parts
        notes += refused_counts
    return counted_parts, notes


def plate_table(plate: "PlateProfile", plate_fit: "PlateFit") -> list[str]:
    """Lines: the plate with its intervals, how far to trust it, and a row a part."""
    heads = [
        Column("part", left=True),
        Column("counted"),
        Column("error", "points"),
        Column("if left out", "points"),
        Column("by default", "points"),
    ]
    rows = [
        [
            part.part_id,
            str(part.total),
            percent(part.error),
            percent(part.left_out_error),
            percent(part.default_error),
        ]
        for part in plate_fit.parts
    ]
    lines = [
        f"plate {plate.name}, from {several(plate_fit.total, 'count')} of "
        f"{several(len(plate_fit.parts), 'part')}",
        "effective restitution {:.2f} ({:.2f} to {:.2f}), ".format(
            *plate_fit.restitution
        )
        + "effective drop height {} ({} to {}); 90 % intervals".format(
            *map(describe_height, plate_fit.drop_height)
        ),
    ]
    if plate.tells_round_sides:
        lines.append(
            "round parts roll as on {} sides a turn ({} to {} are not excluded)".format(
                *plate_fit.round_sides
            )
        )
    test = "nothing is left to test it"
    if not math.isnan(plate_fit.p_value):
        test = f"p-value {plate_fit.p_value:.2g}"
    return [
        *lines,
        f"expected error on another part: {percent(plate_fit.plate_error)} points, by "
        f"the default {percent(plate_fit.default_error)}; {test}",
        "",
        *columns(heads, rows),
        "error: of the part's shares in this scene, in the one that the others ask "
        "for, and in the default one",
    ]


def describe_height(metres: float) -> str:
    """A drop height; 0 stands for the default, in radii of the part."""
    if metres > 0.0:
        return length_in_words(metres)
    return f"{DEFAULT_DROP_RADII:g} part radii"
