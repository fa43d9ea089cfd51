"""`bag DIR...`: parts, jobs and counts of cameras in recorded bags, also as CSV files."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ....base import files, text
from ....core.records.scene import Numbering
from .. import arguments as given, running

if TYPE_CHECKING:
    from ...bags.comparisons import BagAnalysis, PartAnalysis
    from ...bags.results import ResultHistory


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "bag",
        help="analyse recorded bags",
        description="Show results, jobs and camera counts in bags of the node, or recorded by "
        "`ros2 bag record`, and compare estimates, simulations and counts with each other.",
        examples=("ros_pose_stats bag ~/.ros/pose_stats --csv tables",),
        run=run,
    )
    command.add_argument(
        "bags",
        metavar="DIR",
        nargs="+",
        help="bag directory, directory of many bags, or single file",
    )
    command.add_argument(
        "--csv", metavar="DIR", help="write tables as CSV files into a directory"
    )
    given.add(command, "--json")


def run(options: argparse.Namespace) -> int:
    """Analyse and print."""
    from ...bags.comparisons import analyse_bags

    folder = None if options.csv is None else given.folder(options.csv)
    if folder is not None:
        files.refuse_unwritable(folder)
    with running.ProgressBar(sys.stderr) as bar:
        found = analyse_bags(options.bags, bar.show_bytes)
    written = [] if folder is None else write_csv(found, folder)
    if options.json:
        from ...bags.plain import as_dict

        extra = {"csv": written} if folder is not None else {}
        running.print_json({**as_dict(found), **extra})
    else:
        from .report import bag_report

        print(
            "\n".join(
                [bag_report(found), *(["", *map(str, written)] if written else [])]
            )
        )
    return 0


Rows = Iterator[Sequence[Any]]

PART = " ".join(("part_id part_digest", *Numbering._fields))
SCENE = "method restitution drop_height drops"
SHAPE = "index group height top margin barrier spread"
SHARES = "probability probability_low probability_high standard_error count"
RESULT = (
    f"time {SCENE} unsettled expected_error largest_error largest_change final latched"
)
JOB = (
    "job_id state refinement queued started ended drops_done drops seed restitution "
    "drop_height cluster_tolerance round_sides target_error max_seconds message"
)
TEST = "statistic degrees_of_freedom p_value bins pooled"
VALUES = {
    "files": "bag path state note messages",
    "poses": f"{PART} {SCENE} {SHAPE} down_x down_y down_z {SHARES} prediction",
    "answers": f"{PART} {RESULT} scene result prediction index probability",
    "jobs": f"part_id part_digest {JOB}",
    "counts": f"{PART} plate drop_height begin end index count share share_low share_high problem",
    "comparison": f"{PART} counts_of counted {SCENE} rms largest largest_pose by {TEST} "
    "unforeseen",
}
"""Of the rows of each file. Probabilities, shares and errors are fractions."""

TIMES = ("time", "begin", "end", "queued", "started", "ended")
COLUMNS = {
    **{name: f"{name}_m" for name in ("drop_height", "height", "top", "barrier")},
    **{name: f"{name}_rad" for name in ("margin", "spread")},
    **{name: f"{name}_utc" for name in TIMES},
    "max_seconds": "max_seconds_s",
    "path": "file",
    "index": "pose",
    "problem": "not_compared",
    "largest": "largest_difference",
    "statistic": "chi_square",
    "unforeseen": "counted_where_probability_0",
}
"""Of values whose column has another name."""


def write_csv(found: "BagAnalysis", folder: Path) -> list[Path]:
    """Write all files or none; return their paths."""

    def write(aside: Path) -> None:
        for name, values in VALUES.items():
            heads = [COLUMNS.get(one, one) for one in values.split()]
            with (aside / f"{name}.csv").open(
                "w", encoding="utf-8", errors="replace"
            ) as file:
                file.writelines(text.csv_lines(heads, ROWS[name](found)))

    return files.write_whole(folder, write)


def _utc(nanoseconds: int) -> str:
    if not nanoseconds:
        return ""
    second = datetime.fromtimestamp(nanoseconds // text.SECOND, timezone.utc)
    return f"{second:%Y-%m-%dT%H:%M:%S}.{nanoseconds % text.SECOND:09d}Z"


def _columns(*columns: Any) -> Rows:
    """Rows of plain values out of arrays of equal length."""
    return zip(*(column.tolist() for column in columns), strict=True)


def _values(source: Any, names: str) -> list[Any]:
    return [getattr(source, name) for name in names.split()]


def _name(part: "PartAnalysis", history: "ResultHistory") -> tuple[Any, ...]:
    return part.record.part_id, part.record.part_digest, *history.numbering


def _histories(
    found: "BagAnalysis",
) -> "Iterator[tuple[ResultHistory, tuple[Any, ...]]]":
    """Yield every numbering of every part, with the first cells of its rows."""
    for part in found.parts:
        for history in part.record.histories:
            yield history, _name(part, history)


def _files(found: "BagAnalysis") -> Rows:
    return (
        list(map(str, _values(file, VALUES["files"]))) for file in found.contents.files
    )


def _poses(found: "BagAnalysis") -> Rows:
    for history, head in _histories(found):
        poses = history.poses
        for number, one in enumerate(history.predictions):
            for row in _columns(
                *_values(poses, SHAPE), *poses.down.T, *_values(one, SHARES)
            ):
                yield *head, *_values(one, SCENE), *row, number


def _answers(found: "BagAnalysis") -> Rows:
    for history, head in _histories(found):
        poses = history.poses.index.tolist()
        rows = _columns(*_values(history, f"{RESULT} prediction probability"))
        for number, (row, scene) in enumerate(
            zip(rows, history.scene, strict=True), start=1
        ):
            time, *cells, prediction, probabilities = row
            for pose, probability in zip(poses, probabilities, strict=True):
                yield (
                    *head,
                    _utc(time),
                    *cells,
                    scene,
                    number,
                    prediction,
                    pose,
                    probability,
                )


def _jobs(found: "BagAnalysis") -> Rows:
    for part in found.parts:
        for job in part.record.jobs:
            yield (
                part.record.part_id,
                part.record.part_digest,
                *(
                    _utc(getattr(job, name)) if name in TIMES else getattr(job, name)
                    for name in JOB.split()
                ),
            )


def _counts(found: "BagAnalysis") -> Rows:
    for one in (*(each for part in found.parts for each in part.counts), *found.strays):
        of = one.counts
        head = (
            of.part_id,
            of.part_digest,
            *of.numbering,
            of.plate,
            of.drop_height,
            _utc(of.begin),
            _utc(of.end),
        )
        if one.history is None:
            for pose, count in _columns(of.index, of.count):
                yield *head, pose, count, "", "", "", one.problem
        else:
            for row in _columns(
                one.history.poses.index, one.count, one.share, *one.bounds
            ):
                yield *head, *row, one.problem
        yield (
            *head,
            "unclassified",
            of.unclassified,
            of.unclassified_share,
            "",
            "",
            one.problem,
        )


def _comparison(found: "BagAnalysis") -> Rows:
    for part in found.parts:
        compared = [
            ("simulation", int(one.simulation.count.sum()), each, history)
            for history, simulations in zip(
                part.record.histories, part.simulations, strict=True
            )
            for one in simulations
            for each in one.estimates
        ]
        compared += [
            ("camera", counts.counts.classified, each, counts.history)
            for counts in part.counts
            if counts.history
            for each in counts.predictions
        ]
        for of, counted, one, history in compared:
            for by, test in (("pose", one.by_pose), ("group", one.by_group)):
                yield (
                    *_name(part, history),
                    of,
                    counted,
                    *_values(one.prediction, SCENE),
                    one.rms,
                    one.largest,
                    one.largest_pose,
                    by,
                    *_values(test, TEST),
                    one.unforeseen,
                )


ROWS = {
    "files": _files,
    "poses": _poses,
    "answers": _answers,
    "jobs": _jobs,
    "counts": _counts,
    "comparison": _comparison,
}
