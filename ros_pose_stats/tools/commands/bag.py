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

"""`bag DIR...`: parts, jobs and counts of cameras in bags, also as CSV files."""

import argparse

from ...base import files
from .terminal import arguments, running


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "bag",
        help="analyse recorded bags",
        description="Show results, jobs and camera counts in bags of the node, or "
        "recorded by `ros2 bag record`, and compare estimates, simulations and counts "
        "with each other. Bags of a node that ended without an index get it.",
        examples=("ros_pose_stats bag ~/.ros/pose_stats --csv tables",),
        run=run,
    )
    command.add_argument(
        "bags",
        metavar="DIR",
        nargs="+",
        help="bag directory, directory of many bags, or single file; or a CSV file of "
        "counts with the columns part (its file), pose (index) and count",
    )
    arguments.add_options(command, "--unit", help=arguments.SHARED_UNIT_HELP)
    command.add_argument(
        "--csv", metavar="DIR", help="write tables as CSV files into a directory"
    )
    arguments.add_options(command, "--json")


def run(options: argparse.Namespace) -> int:
    """Analyse and print; index bags that a node had no time to index."""
    from ...node.recording import repair
    from ..bags.comparisons import analyse_bags

    folder = None
    if options.csv is not None:
        folder = arguments.output_folder(options.csv)
        files.refuse_unwritable(folder)
    tables, bags = arguments.split_tables(options.bags)
    counts = []
    if tables:
        from ..bags.plate_counts import read_table_counts

        for table in tables:
            counts += read_table_counts(table, options.unit)
    with running.ProgressBar() as bar:
        analysis = analyse_bags(bags, bar.show_bytes, counts)
    written_files = []
    if folder is not None:
        from .tables.bag_csv import write_tables

        written_files = write_tables(analysis, folder)
    if options.json:
        from ..bags.plain import as_dict

        values = as_dict(analysis)
        if folder is not None:
            values["csv"] = written_files
        running.print_json(values)
    else:
        from .tables.bag_report import bag_report

        print(bag_report(analysis))
        if written_files:
            print("", *written_files, sep="\n")
    for bag in analysis.contents.whole_bags:
        repair.index_bag(bag)
    return 0
