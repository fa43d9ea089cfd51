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

"""`report PART`: a page about a part's poses, to look at and to send."""

import argparse
import os
import shlex
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...base import extras, text
from ...base.errors import RequestError
from ...core.records.scene import DEFAULT_SEED
from .terminal import arguments, cells, running

if TYPE_CHECKING:
    from ...core.planning.feeder_cell import FeederCell

CAD_SYSTEMS = ("freecad", "cadquery", "build123d")


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "report",
        help="write a page about a part's poses, to look at and to send",
        description="Write one HTML page about a part: pictures of its stable poses on "
        "the plate, which can be turned, their probabilities by every method, and what "
        "they mean for a feeder. The page needs no network.",
        examples=(
            "ros_pose_stats report demo/clamp.stl --unit mm --wanted 0,1 --rate 60 "
            "-o clamp.html",
            "ros_pose_stats report demo/clamp.stl --unit mm --wanted 0,1 --rate 60 "
            "--kick 0.02 --cycle-time 0.5 -o clamp.html",
            "ros_pose_stats report demo/clamp.stl --unit mm --wanted 0 --changes "
            "-o clamp.html",
            "ros_pose_stats report demo/clamp.stl --unit mm --count-sheet "
            "-o sheet.html",
            "ros_pose_stats report demo/clamp.stl --unit mm --wanted 0 --watch",
            "ros_pose_stats report bracket.stl --unit mm --watch --cad freecad",
        ),
        run=run,
    )
    arguments.add_part(command, "--accept-open", *arguments.POSE_OPTIONS)
    output = command.add_mutually_exclusive_group(required=True)
    output.add_argument(
        "-o", "--output", metavar="FILE", help="the page to write, FILE.html"
    )
    output.add_argument(
        "--watch",
        action="store_true",
        help="serve a page on a local address in place of writing one: it shows each "
        "version of the part as soon as its file is saved, and what changed",
    )
    command.add_argument(
        "--count-sheet",
        action="store_true",
        help="write a sheet to count by hand in place of the page, for A4: pictures of "
        "the poses, boxes to tick, which error how many throws leave; and beside it "
        "counts.csv for the sums, which `fit`, `feeding --counts` and `bag` read",
    )
    add_watch(command)
    add_page(command)
    arguments.add_options(
        command,
        "--seed",
        help="the same seed gives the same drops and flips (default: 1, as `estimate`)",
    )
    arguments.add_options(command, *arguments.SCENE_OPTIONS)


def add_watch(command: arguments.CommandParser) -> None:
    """Add the options of a page that follows the file."""
    command.add_argument(
        "--port",
        type=arguments.read_count,
        metavar="N",
        help="with --watch: the port of the address (default: any that is free)",
    )
    command.add_argument(
        "--no-browser",
        action="store_true",
        help="with --watch: open no browser; the address is printed",
    )
    command.add_argument(
        "--cad",
        choices=CAD_SYSTEMS,
        metavar="SYSTEM",
        help="with --watch: print the lines that have a CAD system write its part "
        f"over the file whenever it computes it; one of {', '.join(CAD_SYSTEMS)}",
    )


def add_page(command: arguments.CommandParser) -> None:
    """Add the options of a page that is written; --wanted is for both."""
    arguments.add_options(
        command,
        "--png",
        help="write the key figure, too: the poses, their probabilities "
        "with intervals and the splitting graph, as FILE.png",
    )
    arguments.add_options(
        command,
        "--wanted",
        default=[],
        help="poses that the feeder accepts, for instance "
        "0 1 or 0-3: the page says which share of the parts is accepted",
    )
    cells.add_cell(
        command,
        default=None,
        help="parts that can be dropped a minute; with --wanted the page says how many "
        "a cell gets, and how",
    )
    arguments.add_options(
        command,
        "--kick",
        help=f"{arguments.KICK_HELP}; with --wanted and --rate the page sets the "
        "cell's own kick beside usual ones, and says which is best, if any",
    )
    arguments.add_options(command, "--flips")
    command.add_argument(
        "--changes",
        action="store_true",
        help="with --wanted: the page says which changes of the part raise the "
        "accepted share, as the command sensitivity does",
    )
    arguments.add_options(
        command,
        "--drops",
        help="have the page be by so many drops alone, as `simulate` makes them "
        "(default: by the answer of `estimate`, which has an estimate beside them)",
    )


def run(options: argparse.Namespace) -> int:
    """Investigate the part, write the page, and print what was written."""
    check_watch(options)
    if options.watch:
        return watch(options)
    page = running.page_file(options.output)
    if options.count_sheet:
        return write_sheet(page, options)
    picture = running.picture_file(options.png)
    with running.announce_slow_start(), running.end_on_interrupt():
        from ...base.files import write_file
        from ..plots import figures, shares
        from ..report.findings import Feeder, investigate
        from ..report.page import report_page

        part = running.load_named_part(options)
    feeder = Feeder(
        tuple(dict.fromkeys(options.wanted)),
        cell_of(options),
        options.kick,
        options.flips,
        options.pixel,
        options.changes,
    )
    scene = arguments.drop_scene(options)
    with running.end_on_interrupt(), running.ProgressBar() as bar:
        findings = investigate(
            part, scene, feeder, options.drops, options.seed, bar.draw
        )
        answer = findings.answer
        bar.draw(1.0, "pictures")
        html = report_page(findings, commands_to_reproduce(options))
        write_file(page, html.encode(errors="replace"))
        if picture is not None:
            statistics = (answer, findings.best_estimate)
            figure = shares.key_picture(part, statistics, findings.graph)
            write_file(picture, figures.png_bytes(figure))
    print(
        f"{part.part_id}: {answer.scene}\n{running.describe_size(page)}, "
        f"{text.several(len(answer.poses), 'pose')}, {answer.drops} drops"
    )
    if picture is not None:
        print(running.describe_size(picture))
    return 0


def write_sheet(page: Path, options: argparse.Namespace) -> int:
    """Write a sheet to count by hand, and rows for the part in its table."""
    refuse_beside(
        "--count-sheet with the part and the scene",
        ("wanted", "seed", *WRITTEN),
        options,
    )
    part = running.load_part_and_kernels(options)
    from ...base.files import write_file
    from ...core.planning.auto import estimate
    from ..report.count_sheet import TABLE, sheet_page, table_with

    with running.end_on_interrupt():
        statistics = estimate(part, **arguments.scene_keywords(options))
        table = page.with_name(TABLE)
        rows = table_with(table, Path(options.part), statistics)
        html = sheet_page(part, statistics, commands_after_counting(options, TABLE))
        write_file(page, html.encode(errors="replace"))
        if rows is not None:
            write_file(table, rows)
    state = "has the part already and stays as it is"
    if rows is not None:
        state = "has a row a pose for the sums"
    print(
        f"{part.part_id}: {statistics.scene}\n{running.describe_size(page)}, for A4\n"
        f"{text.printable(str(table))}: {state}"
    )
    return 0


def commands_after_counting(options: argparse.Namespace, table: str) -> list[str]:
    """Commands that take counts: a plate of several parts, a cell of this one."""
    values = vars(options)
    unit = arguments.option_words(values, "unit")
    numbering = ("cluster_tolerance", "round_sides")
    part_words = [
        options.part,
        *unit,
        *arguments.option_words(values, "body", "com", "mass", "density", *numbering),
    ]
    words = (
        ["fit", table, *unit, "--plate", "NAME"],
        ["feeding", *part_words, "--wanted", "0", "--counts", table],
        ["bag", "BAG", table, *unit],
    )
    return [shlex.join(["ros_pose_stats", *command]) for command in words]


WRITTEN = ("png", "rate", "kick", "flips", "plate", "pixel", "changes", "drops")
"""Options of a page that is written; the one that follows the file has none of it."""


def check_watch(options: argparse.Namespace) -> None:
    """Refuse options of a page that is written beside --watch, and the reverse."""
    if options.watch:
        refuse_beside(
            "--watch with the part, the scene, --wanted and --seed",
            ("count_sheet", *WRITTEN),
            options,
        )
    elif options.cad or options.port is not None or options.no_browser:
        raise RequestError(
            "--port, --no-browser and --cad with --watch",
            "-o",
            "add --watch in its place",
        )


def refuse_beside(
    expected: str, names: Sequence[str], options: argparse.Namespace
) -> None:
    """Refuse options that say nothing about what was asked for."""
    words = arguments.option_words(vars(options), *names)
    if words:
        raise RequestError(expected, words[0], "write a page with it: -o FILE.html")


def watch(options: argparse.Namespace) -> int:
    """Serve a page that follows the file, until Ctrl-C or SIGTERM."""
    extras.require_modules("jinja2", "matplotlib", "PIL")
    with running.preparing_kernels():
        from ..watching import page
        from ..watching.cad_lines import cad_lines
        from ..watching.followed_file import FollowedFile
        from ..watching.news import NewsBoard
        from ..watching.server import PageServer
        from ..watching.serving import serve
        from ..watching.session import Session
        from ..watching.versions import History

    path = Path(options.part)
    name = text.printable(path.name)
    if options.cad is not None:
        print(cad_lines(options.cad, path))
    board = NewsBoard()
    session = Session(
        FollowedFile(path),
        lambda: running.load_named_part(options),
        arguments.drop_scene(options),
        History(tuple(dict.fromkeys(options.wanted))),
        options.seed,
        board,
        lambda line: print(text.printable(line), flush=True),
    )
    with PageServer(
        options.port or 0, page.frame_page(name), page.page_script(), board
    ) as server:
        with running.end_on_interrupt():
            session.begin()
        print(f"{name} is followed on {server.address} until Ctrl-C", flush=True)
        if not options.no_browser:
            open_browser(server.address)
        serve(server, session)
    return 0


def open_browser(address: str) -> None:
    """Show an address where there is a screen; else a browser takes the terminal."""
    if sys.platform == "linux" and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        return
    import webbrowser

    threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()


def cell_of(options: argparse.Namespace) -> "FeederCell | None":
    """The cell of the page, which only a rate asks for."""
    if options.rate is None:
        if options.kick is not None or options.plate is not None:
            raise RequestError(
                "a rate of parts a minute beside a kick or a plate",
                "none",
                "count the parts that can be dropped, those sent back included",
            )
        return None
    return cells.read_cell(options)


def commands_to_reproduce(options: argparse.Namespace) -> tuple[str, ...]:
    """Commands that give the same page again, and the same answer as a table."""
    values = vars(options)
    file = Path(options.part).name
    part_words = [
        f"./{file}" if file.startswith("-") else file,
        *arguments.option_words(
            values,
            "unit",
            "body",
            "accept_open",
            "com",
            "mass",
            "density",
            *arguments.SCENE_NAMES,
        ),
    ]
    seed = DEFAULT_SEED if options.seed is None else options.seed
    table = "estimate"
    drop_words = ["--seed", str(seed)]
    if options.drops is not None:
        table = "simulate"
        drop_words += ["--drops", str(options.drops)]
    cell_options = () if options.rate is None else cells.CELL_OPTIONS
    feeder_words = arguments.option_words(
        values, "wanted", *cell_options, "kick", "flips", "pixel", "changes"
    )
    page_words = ["-o", Path(options.output).name]
    return tuple(
        shlex.join(["ros_pose_stats", *words])
        for words in (
            ["report", *part_words, *drop_words, *feeder_words, *page_words],
            [table, *part_words, *drop_words],
        )
    )
