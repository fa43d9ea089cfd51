"""`fit COUNTS...`: the restitution and drop height that stand for a plate, from what it did."""

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ....base.errors import PoseStatsError, RequestError
from ....base.text import Column, columns, length_in_words, listed, percent, several
from ....core.records.scene import DEFAULT_DROP_RADII
from .. import arguments as given, running

if TYPE_CHECKING:
    from ....core.plates import CountedPart, PlateFit, PlateProfile
    from ....core.records import Part

TABLES = (".csv", ".tsv", ".txt")


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "fit",
        help="fit a plate's restitution and drop height to what was counted on it",
        description="Find the restitution and the drop height at which the model explains best "
        "what was counted on a plate, say how far to trust them, and write them into a file of "
        "plates.",
        examples=(
            "ros_pose_stats fit counts.csv --unit mm --plate glass",
            "ros_pose_stats fit ~/.ros/pose_stats --plate glass --plates cell/plates.yaml",
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
    given.add(command, "--unit", help=given.SHARED_UNIT)
    given.add(
        command,
        *given.POSES_OF,
        help="with which the poses in the CSV are numbered (default: %(default)s)",
    )
    given.add(command, "--json")


def run(options: argparse.Namespace) -> int:
    """Fit, write the plate and print."""
    with running.preparing_kernels():
        from ....base.files import refuse_unwritable
        from ....core.plates import fit, profile as profiles

        file = Path(options.plates)
        profiles.refuse_name(options.plate)
        refuse_unwritable(file.parent)
        profiles.refuse_foreign(file)
        counted, notes = _read_counts(options)
    with running.end_on_interrupt():
        found = fit.fit_plate(counted)
    fitted = {part.part_digest for part in found.parts}
    if beside := {
        one.part.part_id: None for one in counted if one.part.digest not in fitted
    }:
        notes.append(
            f"not in the fit: {listed(list(beside))}; it takes the {fit.MOST_PARTS} "
            "parts counted most of those that can lie in two ways"
        )
    for note in notes:
        print(f"ros_pose_stats: {note}", file=sys.stderr)
    profile = profiles.profile_of(options.plate, found)
    profiles.write_profile(file, profile)
    if options.json:
        running.print_json(
            {
                "plate": profile.name,
                **profile.as_dict(),
                "file": str(file),
                "seconds": found.seconds,
                "verdict": found.verdict,
                "evidence": [
                    {
                        "part_id": part.part_id,
                        "part_digest": part.part_digest,
                        "counted": part.counted,
                        "groups": [
                            {"poses": poses, "observed": observed, "expected": expected}
                            for poses, observed, expected in zip(
                                part.poses, part.observed, part.expected, strict=True
                            )
                        ],
                        "error": part.error,
                        "left_out_error": part.left_out_error,
                    }
                    for part in found.parts
                ],
                "notes": notes,
            }
        )
    else:
        print("\n".join([*_lines(profile, found), "", f"wrote {file}"]))
    return 0


def _read_counts(options: argparse.Namespace) -> "tuple[list[CountedPart], list[str]]":
    from ....core.mesh.parts import load_part
    from ....core.plates import count_part, read_count_rows

    named = {Path(name).resolve(): Path(name) for name in options.counts}.values()
    tables = [file for file in named if file.suffix.lower() in TABLES]
    bags = [file for file in named if file not in tables]
    counted = [
        count_part(
            load_part(part, options.unit, unless_declared=True),
            counts,
            cluster_tolerance=options.cluster_tolerance,
            round_sides=options.round_sides,
        )
        for table in tables
        for part, counts in read_count_rows(table).items()
    ]
    notes = [
        f"{one.part.part_id}: {warning}"
        for one in counted
        for warning in one.part.warnings
    ]
    if not bags:
        return counted, notes
    with running.ProgressBar(sys.stderr) as bar:
        recorded, left_out = counts_on_plate(bags, options.plate, bar.show_bytes)
    return [*counted, *recorded], [*notes, *left_out]


def _lines(profile: "PlateProfile", found: "PlateFit") -> list[str]:
    heads = [
        Column("part", left=True),
        Column("counted"),
        Column("error", "points"),
        Column("if left out", "points"),
    ]
    rows = [
        [
            part.part_id,
            str(part.counted),
            percent(part.error),
            percent(part.left_out_error),
        ]
        for part in found.parts
    ]
    height = [
        length_in_words(metres)
        if metres > 0.0
        else f"{DEFAULT_DROP_RADII:g} part radii"
        for metres in found.drop_height
    ]
    fits = (
        "nothing is left to test it"
        if math.isnan(found.p_value)
        else f"p-value {found.p_value:.2g}"
    )
    rolling = (
        [
            "round parts roll as on {} sides a turn ({} to {} are not excluded)".format(
                *found.round_sides
            )
        ]
        if profile.tells_round_sides
        else []
    )
    return [
        f"plate {profile.name}, from {several(found.counted, 'count')} of "
        f"{several(len(found.parts), 'part')}",
        "effective restitution {:.2f} ({:.2f} to {:.2f}), ".format(*found.restitution)
        + "effective drop height {} ({} to {}); 90 % intervals".format(*height),
        *rolling,
        found.verdict,
        f"expected error on another part: {percent(found.plate_error)} points; {fits}",
        "",
        *columns(heads, rows),
        "error: of the part's shares in this scene, and in the one that the others ask for",
    ]


def counts_on_plate(
    paths: Sequence[Path],
    plate: str,
    on_progress: Callable[[int, int], None] | None = None,
) -> "tuple[list[CountedPart], list[str]]":
    """Counts of a plate with their parts from the same bags, and what could not be used.

    Counts that name no plate are taken too, as those of the only plate there was.
    """
    from ....core.plates import count_part
    from ...bags.bag_reader import read_bags, read_parts

    told = read_bags(paths, on_progress).counts
    wanted = [one for one in told if one.plate in ("", plate) and one.classified]
    if not wanted:
        plates = sorted({one.plate for one in told if one.plate})
        raise RequestError(
            f"counts of cameras on plate {plate}",
            f"those of {listed(plates)}" if plates else "none",
            "name its plate, or record ~/pose_counts",
        )
    missing = {one.part_digest for one in wanted}
    parts: dict[str, Part] = {}
    for part in read_parts(paths):
        parts.setdefault(part.digest, part)
        missing.discard(part.digest)
        if not missing:
            break
    counted = []
    notes = []
    for one in wanted:
        fitting = [
            part
            for part in parts.values()
            if (
                part.digest == one.part_digest
                if one.part_digest
                else part.part_id == one.part_id
            )
        ]
        why = (
            "several parts have this name, and the counts carry no digest"
            if len(fitting) > 1
            else "its mesh is not in the bags"
            if not fitting
            else "they do not say by which cluster_tolerance the poses are numbered"
            if math.isnan(one.numbering.cluster_tolerance)
            else ""
        )
        if not why:
            try:
                counted.append(
                    count_part(fitting[0], one.of_pose, **one.numbering._asdict())
                )
            except PoseStatsError as error:
                why = str(error)
        if why:
            notes.append(
                f"{several(one.classified, 'count')} of {one.part_id} left out: {why}"
            )
    return counted, notes
