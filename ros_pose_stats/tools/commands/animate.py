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

"""`animate PART`: one drop of a part in motion."""

import argparse
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.extras import require_modules
from ...core.records.notes import note_lines
from ...core.records.scene import HIGHEST_DROP, height_warnings
from .terminal import arguments, running

if TYPE_CHECKING:
    from ...core.records import Part, Trajectory
    from ...core.resting.splitting_graph import SplittingNode
    from ...core.simulation.frames import DropFrames
    from ..plots.figures import Picture

VIDEO_ENDINGS = (".gif", ".mp4")
FILM_ENDING = ".mcap"


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "animate",
        help="show one drop of a part in motion",
        description="Show one drop of a part: falling, bouncing, settling, with its "
        "energy and the poses still within reach. The horizontal motion is left out, "
        "as in the model.",
        examples=(
            "ros_pose_stats animate demo/clamp.stl --unit mm --drop 10 --seed 7 "
            "-o drop.mcap",
        ),
        run=run,
    )
    arguments.add_part(command, "--accept-open", *arguments.POSE_OPTIONS)
    command.add_argument(
        "--drop",
        type=arguments.read_count,
        default=0,
        metavar="K",
        help="number of the drop in the simulation with the same seed "
        "(default: %(default)s)",
    )
    arguments.add_options(
        command,
        "--output",
        required=True,
        help="the file to write: FILE.gif, FILE.mp4 "
        "(needs ffmpeg) or FILE.mcap (for Foxglove and RViz)",
    )
    arguments.add_options(command, "--seed", *arguments.SCENE_OPTIONS)


def run(options: argparse.Namespace) -> int:
    """Record the drop, draw it and say how it ended."""
    file = running.output_file(options.output, (*VIDEO_ENDINGS, FILM_ENDING))
    if file.suffix.lower() in VIDEO_ENDINGS:
        require_modules("matplotlib", "PIL")
    with running.announce_slow_start(), running.end_on_interrupt():
        from ...core.resting.poses import poses_in
        from ...core.resting.splitting_graph import splitting_graph
        from ...core.simulation import frames, request

        if file.suffix.lower() == ".mp4":
            from ..plots.figures import ffmpeg

            ffmpeg()
        part = running.load_named_part(options)
        scene = arguments.drop_scene(options)
        seed = request.drop_request(None, options.seed).seed
        trajectory = frames.watchable_drop(part, scene, seed, options.drop)
        resting_poses = poses_in(part, scene)
        drop_frames = frames.drop_frames(part, trajectory, resting_poses)
        root = splitting_graph(resting_poses)
    write_drop(file, part, trajectory, drop_frames, root)
    print(
        f"{part.part_id}: {trajectory.scene}",
        f"drop {options.drop}, seed {seed}: {trajectory.impacts} impacts, at rest in "
        f"pose {trajectory.pose}",
        running.describe_size(file),
        *note_lines(
            height_warnings("drop", scene.drop_height, trajectory.radius, HIGHEST_DROP)
        ),
        sep="\n",
    )
    return 0


def write_drop(
    file: Path,
    part: "Part",
    trajectory: "Trajectory",
    frames: "DropFrames",
    root: "SplittingNode",
) -> None:
    """Write the drop as a film for Foxglove or as a video, whole or not at all."""
    from ...base.files import write_whole

    def write_film(folder: Path) -> None:
        """A bag with the part in motion, and the poses within reach of its energy."""
        from ...core.resting.splitting_graph import levels_above, poses_within
        from ...node.recording.writer import drop_film

        weight = trajectory.energies[0] / trajectory.heights[0]
        levels = levels_above(root, trajectory.pose)

        def name_poses(energy: float) -> str:
            return " ".join(map(str, poses_within(levels, energy / weight, root.poses)))

        drop_film.write_film(folder / file.name, part, frames, name_poses)

    def write_video(folder: Path) -> None:
        from ...core.simulation.frames import RATE
        from ..plots import figures
        from ..plots.trajectory import animation_frames

        pictures = animation_frames(part, trajectory, frames, root)
        is_gif = file.suffix.lower() == ".gif"
        write = figures.write_gif if is_gif else figures.write_mp4
        total = len(frames.times)
        write(folder / file.name, count_pictures(pictures, total), RATE)

    is_film = file.suffix.lower() == FILM_ENDING
    write_whole(file.parent, write_film if is_film else write_video)


def count_pictures(pictures: "Iterable[Picture]", total: int) -> "Iterator[Picture]":
    """The same pictures, while a bar says how many there have been."""
    with running.ProgressBar() as bar:
        for count, picture in enumerate(pictures):
            bar.draw(count / total, f"picture {count} of {total}")
            yield picture
