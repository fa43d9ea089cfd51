"""`report PART` and `animate PART`: all about a part's poses on a page, and one drop in motion."""

import argparse
import shlex
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ...core.records.scene import HIGHEST_DROP, height_warnings
from . import arguments as given, running

if TYPE_CHECKING:
    from ...core.records import Part, PoseStatistics, Trajectory
    from ...core.resting.splitting_graph import SplittingNode
    from ...core.simulation.frames import DropFrames
    from ..plots.figures import Picture


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "report",
        help="write a page about a part's poses, to look at and to send",
        description="Write one HTML page about a part: pictures of its stable poses on the plate, "
        "which can be turned, their probabilities by every method, and what they mean for a "
        "feeder. The page needs no network.",
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
    given.add_part(command, *given.POSES_OF)
    given.add(command, "--output", required=True, help="the page to write, FILE.html")
    given.add(
        command,
        "--png",
        help="write the key figure, too: the poses, their probabilities "
        "with intervals and the splitting graph, as FILE.png",
    )
    given.add(
        command,
        "--wanted",
        default=[],
        help="poses that the feeder accepts, for instance "
        "0 1 or 0-3: the page says which share of the parts is accepted",
    )
    given.add(
        command,
        "--rate",
        default=None,
        help="parts dropped a minute, those sent back "
        "included; with --wanted the page says how many are accepted a minute",
    )
    given.add(
        command,
        "--kick",
        help=f"{given.KICK}; with --wanted and --rate the page says what "
        "kicking parts that lie wrong gains, and which kick feeds fastest",
    )
    given.add(command, "--cycle-time")
    command.add_argument(
        "--changes",
        action="store_true",
        help="with --wanted: the page says which changes of the part raise the "
        "accepted share, as the command sensitivity does",
    )
    given.add(
        command,
        "--drops",
        help="number of drops of the simulation (default: as many as "
        "bring the error over the poses within a point, at most 10000)",
    )
    given.add(command, "--seed", *given.SCENE)


def run(options: argparse.Namespace) -> int:
    """Investigate the part, write the page, and print what was written."""
    page = running.output_file(options.output, (".html", ".htm"))
    figure = (
        None if options.png is None else running.output_file(options.png, (".png",))
    )
    with running.announce_slow_start(), running.end_on_interrupt():
        from ...base.files import write_file
        from ...base.text import several
        from ..report import findings as report, page as pages

        part = given.load_named_part(options)
    feeder = report.Feeder(
        tuple(dict.fromkeys(options.wanted)),
        options.rate,
        options.kick,
        options.cycle_time,
        options.changes,
    )
    with running.end_on_interrupt(), running.ProgressBar(sys.stderr) as bar:
        findings = report.investigate(
            part, given.scene_of(options), feeder, options.drops, options.seed, bar.draw
        )
        found = findings.simulated
        bar.draw(1.0, "pictures")
        commands = commands_to_reproduce(options, found)
        write_file(page, pages.report_page(findings, commands).encode(errors="replace"))
        if figure is not None:
            from ..plots import figures, shares

            write_file(
                figure,
                figures.png_bytes(
                    shares.key_picture(
                        part, (found, findings.best_estimate), findings.graph
                    )
                ),
            )
    print(
        f"{part.part_id}: {found.scene}\n{page}: {page.stat().st_size / 1e6:.2f} MB, "
        f"{several(len(found.poses), 'pose')}, {found.drops} drops"
    )
    if figure is not None:
        print(f"{figure}: {figure.stat().st_size / 1e6:.2f} MB")
    return 0


def commands_to_reproduce(
    options: argparse.Namespace, found: "PoseStatistics"
) -> tuple[str, ...]:
    """Commands that give the same page again, and the same counts as a table."""
    typed = vars(options)
    file = Path(options.part).name
    named = [
        f"./{file}" if file.startswith("-") else file,
        *given.typed_again(
            typed,
            "unit",
            "com",
            "mass",
            "density",
            "cluster_tolerance",
            "round_sides",
            "restitution",
            "drop_height",
        ),
    ]
    drops = ["--drops", str(found.drops), "--seed", str(found.seed)]
    asked = given.typed_again(
        typed,
        "wanted",
        "rate",
        "kick",
        *["cycle_time"][: options.kick is not None],
        "changes",
    )
    page = ["report", *named, *drops, *asked, "-o", Path(options.output).name]
    return tuple(
        shlex.join(["ros_pose_stats", *words])
        for words in (page, ["simulate", *named, *drops])
    )


ENDINGS = (".gif", ".mp4", ".mcap")


def register_animate(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "animate",
        help="show one drop of a part in motion",
        description="Show one drop of a part: falling, bouncing, settling, with its energy and "
        "the poses still within reach. The horizontal motion is left out, as in the model.",
        examples=(
            "ros_pose_stats animate demo/clamp.stl --unit mm --drop 10 --seed 7 "
            "-o drop.mcap",
        ),
        run=animate,
    )
    given.add_part(command, *given.POSES_OF)
    command.add_argument(
        "--drop",
        type=given.read_count,
        default=0,
        metavar="K",
        help="number of the drop in the simulation with the same seed "
        "(default: %(default)s)",
    )
    given.add(
        command,
        "--output",
        required=True,
        help="the file to write: FILE.gif, FILE.mp4 "
        "(needs ffmpeg) or FILE.mcap (for Foxglove and RViz)",
    )
    given.add(command, "--seed", *given.SCENE)


def animate(options: argparse.Namespace) -> int:
    """Record the drop, draw it and say how it ended."""
    file = running.output_file(options.output, ENDINGS)
    with running.announce_slow_start(), running.end_on_interrupt():
        from ...core.resting import poses, splitting_graph
        from ...core.simulation import frames as film, request

        if file.suffix.lower() == ".mp4":
            from ..plots.figures import ffmpeg

            ffmpeg()
        part = given.load_named_part(options)
        scene = given.scene_of(options)
        seed = request.drop_request(None, options.seed).seed
        found = film.watchable_drop(part, scene, seed, options.drop)
        resting = poses.poses_in(part, scene)
        frames = film.drop_frames(part, found, resting)
        root = splitting_graph.splitting_graph(resting)
    _write(file, part, found, frames, root)
    print(
        f"{part.part_id}: {found.scene}\n"
        f"drop {options.drop}, seed {seed}: {found.impacts} impacts, at rest in pose "
        f"{found.pose}\n{file}: {file.stat().st_size / 1e6:.2f} MB",
        *height_warnings("drop", scene.drop_height, found.radius, HIGHEST_DROP),
        sep="\n",
    )
    return 0


def _write(
    file: Path,
    part: "Part",
    found: "Trajectory",
    frames: "DropFrames",
    root: "SplittingNode",
) -> None:
    from ...base.files import write_whole

    def write(folder: Path) -> None:
        if file.suffix.lower() == ".mcap":
            from ...core.resting.splitting_graph import levels_above, poses_within
            from ...node.recording.writer.drop_film import write_film

            weight = found.energies[0] / found.heights[0]
            levels = levels_above(root, found.pose)
            write_film(
                folder / file.name,
                part,
                frames,
                lambda energy: " ".join(
                    map(str, poses_within(levels, energy / weight, root.poses))
                ),
            )
            return
        from ...core.simulation.frames import RATE
        from ..plots import figures, trajectory

        pictures = _watched(
            trajectory.animation_frames(part, found, frames, root), len(frames.times)
        )
        (figures.write_mp4 if file.suffix.lower() == ".mp4" else figures.write_gif)(
            folder / file.name, pictures, RATE
        )

    write_whole(file.parent, write)


def _watched(pictures: "Iterable[Picture]", count: int) -> "Iterator[Picture]":
    """The same pictures, while a bar says how many there have been."""
    with running.ProgressBar(sys.stderr) as bar:
        for number, picture in enumerate(pictures):
            bar.draw(number / count, f"picture {number} of {count}")
            yield picture
