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

"""STEP files of one's own, tessellated more and less finely.

    python -m lab.benchmarks.step_deflection FILE|FOLDER ...

The deflection is how far a mesh may be from its curves, as a fraction of each edge;
each is compared with the finest.
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import cascadio
import numpy as np

from lab.bodies.shapes import Surface
from lab.bodies.variants import joined
from lab.frame.timing import timed
from ros_pose_stats import Part, estimate, part_from_mesh
from ros_pose_stats.core.mesh.files import STEP_SUFFIXES
from ros_pose_stats.core.mesh.raw_meshes import RawScene
from ros_pose_stats.core.mesh.step_files import LINEAR, read_step

from .files import files_in

FINEST = 2e-4
DEFLECTIONS = (1e-2, 5e-3, 2e-3, LINEAR)


class Reading(NamedTuple):
    """A file as one deflection has it."""

    seconds: float  # of processor time, to tessellate it
    part: Part


def reading(data: bytes, folder: str, deflection: float) -> Reading:
    """Tessellate and make a part of all bodies."""
    scene, seconds = timed(lambda: read_step(data, folder, deflection))
    return Reading(seconds, part_from_mesh(*whole(scene), body="all"))


def whole(scene: RawScene) -> Surface:
    """Vertices and triangles of all meshes in their places."""
    surfaces = []
    for number, rows in scene.placed:
        mesh = scene.meshes[number]
        matrix = np.reshape(rows, (3, 4))
        points = np.reshape(mesh.vertices, (-1, 3))
        vertices = points @ matrix[:, :3].T + matrix[:, 3]
        surfaces.append((vertices, np.reshape(mesh.corners, (-1, 3))))
    return joined(*surfaces)


def volume(part: Part) -> float:
    """Enclosed by the surface."""
    a, b, c = (part.surface_vertices[part.surface_triangles[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum()) / 6.0


def largest_difference(part: Part, other: Part) -> float:
    """Of the shares of their poses in `split`; 1 where they have other poses."""
    shares, other_shares = (
        sorted(pose.probability for pose in estimate(body, "split").poses)
        for body in (part, other)
    )
    if len(shares) != len(other_shares):
        return 1.0
    return float(np.abs(np.subtract(shares, other_shares)).max())


def main() -> None:
    """Read the arguments, measure and print a line a deflection."""
    parser = argparse.ArgumentParser(prog="lab.benchmarks.step_deflection")
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE|FOLDER")
    files = [
        file.read_bytes()
        for file in files_in(parser.parse_args().files)
        if file.suffix.lower() in STEP_SUFFIXES
    ]
    if not files:
        parser.error("expected STEP files or folders with some, got none")
    folder = str(Path(cascadio.__file__).parents[1])
    finest = [reading(data, folder, FINEST).part for data in files]
    for deflection in DEFLECTIONS:
        readings = [reading(data, folder, deflection) for data in files]
        pairs = [(each.part, fine) for each, fine in zip(readings, finest, strict=True)]
        centers = max(
            float(np.linalg.norm(part.center_of_mass - fine.center_of_mass))
            / float(np.ptp(fine.surface_vertices, axis=0).max())
            for part, fine in pairs
        )
        print(
            f"{deflection:g}: {len(files)} files, "
            f"{sum(each.seconds for each in readings):.2f} s, "
            f"{sum(len(part.triangles) for part, _ in pairs)} triangles; at most "
            f"{max(abs(volume(part) / volume(fine) - 1) for part, fine in pairs):.1e} "
            f"of the volume, {centers:.1e} of the length for the centre of mass, "
            f"{max(largest_difference(*pair) for pair in pairs):.1e} in a share"
        )


if __name__ == "__main__":
    main()
