"""`animate PART`: one drop in motion."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from . import arguments as given
from . import running

if TYPE_CHECKING:
    from ..records import Part, Trajectory
    from ..resting.splitting_graph import SplittingNode
    from ..simulation.frames import DropFrames

ENDINGS = (".gif", ".mp4", ".mcap")


def register(commands: given.Commands) -> None:
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
    given.add_seed_option(command, "seed of the simulation (default: %(default)s)", 1)
    given.add_scene_options(command)
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Record the drop, draw it and say how it ended."""
    file = running.output_file(options.output, ENDINGS)
    with running.announce_slow_start(), running.end_on_interrupt():
        from ..resting.poses import poses_in
        from ..resting.splitting_graph import splitting_graph
        from ..simulation.frames import drop_frames, watchable_drop

        if file.suffix.lower() == ".mp4":
            from ..plots.files import ffmpeg

            ffmpeg()
        part = given.load_named_part(options)
        scene = given.scene_of(options)
        found = watchable_drop(part, scene, options.seed, options.drop)
        resting = poses_in(part, scene)
        frames = drop_frames(part, found, resting)
        _write(file, part, found, frames, splitting_graph(resting))
    print(f"{part.part_id}: {found.scene}\n"
          f"drop {options.drop}, seed {options.seed}: {found.impacts} impacts, at rest in pose "
          f"{found.pose}\n{file}: {file.stat().st_size / 1e6:.2f} MB")
    return 0


def _write(file: Path, part: Part, found: Trajectory, frames: DropFrames,
           root: SplittingNode) -> None:
    from ..files import write_whole

    def write(folder: Path) -> None:
        if file.suffix.lower() == ".mcap":
            _film(folder / file.name, part, found, frames, root)
            return
        from ..plots.files import write_gif, write_mp4
        from ..plots.trajectory import animation_frames
        from ..simulation.frames import RATE

        pictures = animation_frames(part, found, frames, root)
        (write_mp4 if file.suffix.lower() == ".mp4" else write_gif)(
            folder / file.name, pictures, RATE)

    write_whole(file.parent, write)


def _film(file: Path, part: Part, found: Trajectory, frames: DropFrames,
          root: SplittingNode) -> None:
    from ..recording.writer.drop_film import write_film
    from ..resting.splitting_graph import levels_above, poses_within

    weight = found.energies[0] / found.heights[0]
    levels = levels_above(root, found.pose)
    write_film(file, part, frames, lambda energy: " ".join(
        map(str, poses_within(levels, energy / weight, root.poses))))
