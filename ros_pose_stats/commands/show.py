"""`report PART` and `animate PART`: all about a part's poses on a page, and one drop in motion."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from . import arguments as given, running

if TYPE_CHECKING:
    from ..plots.files import Picture
    from ..records import Part, PoseStatistics, Trajectory
    from ..resting.splitting_graph import SplittingNode
    from ..simulation.frames import DropFrames


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "report", help="write a page about a part's poses, to look at and to send",
        description="Write one HTML page about a part: pictures of its stable poses on the plate, "
        "which can be turned, their probabilities by every method, and what they mean for a "
        "feeder. The page needs no network.",
        examples=("ros_pose_stats report demo/clamp.stl --unit mm --wanted 0,1 --rate 60 "
                  "-o clamp.html",
                  "ros_pose_stats report demo/clamp.stl --unit mm --wanted 0,1 --rate 60 "
                  "--kick 0.02 --cycle-time 0.5 -o clamp.html",
                  "ros_pose_stats report demo/clamp.stl --unit mm --wanted 0 --changes "
                  "-o clamp.html"))
    given.add_part_options(command)
    command.add_argument("-o", "--output", required=True, metavar="FILE",
                         help="the page to write, FILE.html")
    command.add_argument("--png", metavar="FILE",
                         help="write the key figure, too: the poses, their probabilities "
                         "with intervals and the splitting graph, as FILE.png")
    given.add_wanted_option(command, "INDEX", "poses that the feeder accepts, separated by spaces "
                            "or commas, or a range such as 0-3: the page says which share of the "
                            "parts is accepted", default=[])
    command.add_argument("--rate", type=float, metavar="PARTS_PER_MIN",
                         help="parts dropped a minute, those sent back included; with --wanted "
                         "the page says how many are accepted a minute")
    command.add_argument("--kick", type=given.read_length, metavar="H",
                         help="energy of a kick over the part's weight, a height as 0.003 "
                         "(metres) or 3mm; with --wanted and --rate the page says what "
                         "kicking parts that lie wrong gains, and which kick feeds fastest")
    command.add_argument("--cycle-time", type=float, default=1.0, metavar="S",
                         help="seconds from one kick to the next (default: %(default)s)")
    command.add_argument("--changes", action="store_true",
                         help="with --wanted: the page says which changes of the part raise the "
                         "accepted share, as the command sensitivity does")
    command.add_argument("--drops", type=given.read_count, metavar="N",
                         help="number of drops of the simulation (default: as many as bring the "
                         "error over the poses within a point, at most 10000)")
    given.add_seed_option(command)
    given.add_scene_options(command)
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Investigate the part, write the page, and print what was written."""
    page = running.output_file(options.output, (".html", ".htm"))
    figure = None if options.png is None else running.output_file(options.png, (".png",))
    with running.announce_slow_start(), running.end_on_interrupt():
        from ..files import write_file
        from ..report.findings import Feeder, investigate
        from ..report.page import report_page
        from ..text import several

        part = given.load_named_part(options)
    feeder = Feeder(tuple(dict.fromkeys(options.wanted)), options.rate, options.kick,
                    options.cycle_time, options.changes)
    with running.end_on_interrupt(), running.ProgressBar(sys.stderr) as bar:
        findings = investigate(part, drops=options.drops, seed=options.seed, feeder=feeder,
                               on_progress=bar.draw, **given.scene_keywords(options))
        found = findings.simulated
        bar.draw(1.0, "pictures")
        write_file(page, report_page(findings, commands_to_reproduce(options, found)).encode())
        if figure is not None:
            from ..plots import files, shares

            write_file(figure, files.png_bytes(shares.key_picture(
                part, (found, findings.best_estimate), findings.graph)))
    print(f"{part.part_id}: {found.scene}\n{page}: {page.stat().st_size / 1e6:.2f} MB, "
          f"{several(len(found.poses), 'pose')}, {found.drops} drops")
    if figure is not None:
        print(f"{figure}: {figure.stat().st_size / 1e6:.2f} MB")
    return 0


def commands_to_reproduce(options: argparse.Namespace, found: PoseStatistics) -> tuple[str, ...]:
    """Commands that give the same page again, and the same counts as a table."""
    named = [Path(options.part).name, "--unit", options.unit]
    if options.com is not None:
        named += ["--com", *(repr(x) for x in options.com)]
    named += ["--cluster-tolerance", repr(options.cluster_tolerance),
              "--round-sides", str(options.round_sides),
              "--restitution", repr(options.restitution)]
    if options.drop_height is not None:
        named += ["--drop-height", repr(options.drop_height)]
    drops = ["--drops", str(found.drops), "--seed", str(found.seed)]
    asked = ["--wanted", *map(str, options.wanted)] if options.wanted else []
    asked += ["--rate", repr(options.rate)] if options.rate is not None else []
    asked += (["--kick", repr(options.kick), "--cycle-time", repr(options.cycle_time)]
              if options.kick is not None else [])
    asked += ["--changes"] if options.changes else []
    page = ["report", *named, *drops, *asked, "-o", Path(options.output).name]
    return tuple(shlex.join(["ros_pose_stats", *words])
                 for words in (page, ["simulate", *named, *drops]))


ENDINGS = (".gif", ".mp4", ".mcap")


def register_animate(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "animate", help="show one drop of a part in motion",
        description="Show one drop of a part: falling, bouncing, settling, with its energy and "
        "the poses still within reach. The horizontal motion is left out, as in the model.",
        examples=("ros_pose_stats animate demo/clamp.stl --unit mm --drop 10 --seed 7 "
                  "-o drop.mcap",))
    given.add_part_options(command)
    command.add_argument("--drop", type=given.read_count, default=0, metavar="K",
                         help="number of the drop in the simulation with the same seed "
                         "(default: %(default)s)")
    command.add_argument("-o", "--output", required=True, metavar="FILE",
                         help="the file to write: FILE.gif, FILE.mp4 (needs ffmpeg) or "
                         "FILE.mcap (for Foxglove and RViz)")
    given.add_seed_option(command)
    given.add_scene_options(command)
    command.set_defaults(run=animate)


def animate(options: argparse.Namespace) -> int:
    """Record the drop, draw it and say how it ended."""
    file = running.output_file(options.output, ENDINGS)
    with running.announce_slow_start(), running.end_on_interrupt():
        from ..resting import poses, splitting_graph
        from ..simulation.frames import drop_frames, watchable_drop
        from ..simulation.request import drop_request

        if file.suffix.lower() == ".mp4":
            from ..plots.files import ffmpeg

            ffmpeg()
        part = given.load_named_part(options)
        scene = given.scene_of(options)
        seed = drop_request(None, options.seed).seed
        found = watchable_drop(part, scene, seed, options.drop)
        resting = poses.poses_in(part, scene)
        frames = drop_frames(part, found, resting)
        _write(file, part, found, frames, splitting_graph.splitting_graph(resting))
    print(f"{part.part_id}: {found.scene}\n"
          f"drop {options.drop}, seed {seed}: {found.impacts} impacts, at rest in pose "
          f"{found.pose}\n{file}: {file.stat().st_size / 1e6:.2f} MB")
    return 0


def _write(file: Path, part: Part, found: Trajectory, frames: DropFrames,
           root: SplittingNode) -> None:
    from ..files import write_whole

    def write(folder: Path) -> None:
        if file.suffix.lower() == ".mcap":
            _film(folder / file.name, part, found, frames, root)
            return
        from ..plots import files, trajectory
        from ..simulation.frames import RATE

        pictures = _watched(trajectory.animation_frames(part, found, frames, root),
                            len(frames.times))
        (files.write_mp4 if file.suffix.lower() == ".mp4" else files.write_gif)(
            folder / file.name, pictures, RATE)

    write_whole(file.parent, write)


def _watched(pictures: Iterable[Picture], count: int) -> Iterator[Picture]:
    """The same pictures, while a bar says how many there have been."""
    with running.ProgressBar(sys.stderr) as bar:
        for number, picture in enumerate(pictures):
            bar.draw(number / count, f"picture {number} of {count}")
            yield picture


def _film(file: Path, part: Part, found: Trajectory, frames: DropFrames,
          root: SplittingNode) -> None:
    from ..recording.writer.drop_film import write_film
    from ..resting.splitting_graph import levels_above, poses_within

    weight = found.energies[0] / found.heights[0]
    levels = levels_above(root, found.pose)
    write_film(file, part, frames, lambda energy: " ".join(
        map(str, poses_within(levels, energy / weight, root.poses))))
