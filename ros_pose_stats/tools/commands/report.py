"""`report PART`: a page about a part's poses, to look at and to send."""

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.errors import RequestError
from .terminal import arguments, cells, running

if TYPE_CHECKING:
    from ...core.planning.feeder_cell import FeederCell
    from ...core.records import PoseStatistics


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
        ),
        run=run,
    )
    arguments.add_part(command, "--accept-open", *arguments.POSE_OPTIONS)
    arguments.add_options(
        command, "--output", required=True, help="the page to write, FILE.html"
    )
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
        help="number of drops of the simulation (default: as many as "
        "bring the error over the poses within a point, at most 10000)",
    )
    arguments.add_options(command, "--seed", *arguments.SCENE_OPTIONS)


def run(options: argparse.Namespace) -> int:
    """Investigate the part, write the page, and print what was written."""
    page = running.page_file(options.output)
    picture = running.picture_file(options.png)
    with running.announce_slow_start(), running.end_on_interrupt():
        from ...base.files import write_file
        from ...base.text import several
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
        simulated = findings.simulated
        bar.draw(1.0, "pictures")
        text = report_page(findings, commands_to_reproduce(options, simulated))
        write_file(page, text.encode(errors="replace"))
        if picture is not None:
            statistics = (simulated, findings.best_estimate)
            figure = shares.key_picture(part, statistics, findings.graph)
            write_file(picture, figures.png_bytes(figure))
    print(
        f"{part.part_id}: {simulated.scene}\n{running.describe_size(page)}, "
        f"{several(len(simulated.poses), 'pose')}, {simulated.drops} drops"
    )
    if picture is not None:
        print(running.describe_size(picture))
    return 0


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


def commands_to_reproduce(
    options: argparse.Namespace, simulated: "PoseStatistics"
) -> tuple[str, ...]:
    """Commands that give the same page again, and the same counts as a table."""
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
    drop_words = ["--drops", str(simulated.drops), "--seed", str(simulated.seed)]
    cell_options = () if options.rate is None else cells.CELL_OPTIONS
    feeder_words = arguments.option_words(
        values, "wanted", *cell_options, "kick", "flips", "pixel", "changes"
    )
    page_words = ["-o", Path(options.output).name]
    return tuple(
        shlex.join(["ros_pose_stats", *words])
        for words in (
            ["report", *part_words, *drop_words, *feeder_words, *page_words],
            ["simulate", *part_words, *drop_words],
        )
    )
