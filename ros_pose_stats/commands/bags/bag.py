"""`bag DIR...`: parts, jobs and counts of cameras in recorded bags."""

import argparse
import sys
from pathlib import Path

from ...errors import BagError
from .. import arguments as given, running


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "bag", help="analyse recorded bags",
        description="Show results, jobs and camera counts in bags of the node, or recorded by "
        "`ros2 bag record`, and compare estimates, simulations and counts with each other.",
        examples=("ros_pose_stats bag ~/.ros/pose_stats --csv tables",))
    command.add_argument("bags", metavar="DIR", nargs="+",
                         help="bag directory, directory of many bags, or single file")
    command.add_argument("--csv", metavar="DIR", help="write tables as CSV files into a directory")
    given.add(command, "--json")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Analyse and print."""
    from ...recording.analysis.comparisons import analyse_bags

    folder = Path(options.csv) if options.csv else None
    if folder is not None and folder.exists() and not folder.is_dir():
        raise BagError("a directory for the CSV files", f"{folder}, which is a file",
                       "name a directory; it is created if it is missing")
    with running.ProgressBar(sys.stderr) as bar:
        found = analyse_bags(options.bags, bar.show_bytes)
    written: list[Path] = []
    if folder is not None:
        from .csv_files import write_csv

        written = write_csv(found, folder)
    if options.json:
        from ...recording.analysis.plain import as_dict

        extra = {"csv": [str(path) for path in written]} if folder is not None else {}
        running.print_json({**as_dict(found), **extra})
    else:
        from .report import bag_report

        print("\n".join([bag_report(found), *(["", *map(str, written)] if written else [])]))
    return 0
