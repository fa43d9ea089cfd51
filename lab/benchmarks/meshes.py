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

"""Large meshes with small hulls, and files beside `trimesh.poses`.

python -m lab.benchmarks.meshes [FILE|FOLDER ...] [--write]

The page names no files, only how many there are.
"""

import gc
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median

import numpy as np
from manifold3d import Manifold, Mesh64
from trimesh import Trimesh
from trimesh.poses import compute_stable_poses

from lab.bodies.fine_parts import surface
from lab.frame.page import ROOT
from lab.frame.results import Row, Section, Target
from lab.frame.timing import timed
from ros_pose_stats import Part, estimate, part_from_mesh
from ros_pose_stats.core.mesh.files import stl_bytes
from ros_pose_stats.core.shapes import demo_parts, profiles

from .files import files_in, loaded
from .program import benchmark_parser, run_benchmark

BODIES = {
    "hexagonal prism": lambda: profiles.prism(6, 10.0, 24.0),
    "bolt": demo_parts.hex_bolt,
    "clamp": demo_parts.clamp,
}
SIZES = (1_000_000, 1_300_000)
"""Triangles."""

LAUNCHER = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True)
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
print(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0)
"""
"""A process begins with the memory of the one that starts it, so that one is small."""

SECONDS = 5.0
MEGABYTES = 800.0
RUNS = 3
ROUNDS = 25

WHOLE = (
    "`ros_pose_stats estimate FILE --unit mm` of binary STL, a process from start to "
    "exit: processor time of all its threads, and the most memory that it had. "
    "Medians of {} runs."
)
BESIDE = (
    "`part_from_mesh` and `estimate(part, 'split')`, beside "
    "`trimesh.poses.compute_stable_poses(mesh, n_samples=1)` on a new `Trimesh` of the "
    "same welded arrays, whose construction is not timed: processor time, in turns. "
    "The garbage collector is off but for trimesh. "
    "Ratios are medians over {} rounds; `slower`: files whose ratio is above 1."
)


def fine_file(folder: Path, name: str, size: int) -> tuple[Path, int]:
    """A body cut into about so many triangles, as an STL file; and how many it has."""
    vertices, triangles = BODIES[name]()
    mesh = Mesh64(np.array(vertices), np.array(triangles, dtype=np.uint64))
    pieces = round((size / len(triangles)) ** 0.5)
    vertices, triangles = surface(Manifold(mesh).refine(pieces))
    path = folder / f"{name.partition(' ')[0]}_{size}.stl"
    path.write_bytes(stl_bytes(vertices, triangles))
    return path, len(triangles)


def cost_of(path: Path) -> tuple[float, float]:
    """Processor seconds and megabytes of a command about a file."""
    estimating = ("-m", "ros_pose_stats", "estimate", str(path), "--unit", "mm")
    launch = [sys.executable, "-c", LAUNCHER, sys.executable, *estimating]
    output = subprocess.run(launch, cwd=ROOT, capture_output=True, check=True).stdout
    seconds, megabytes = map(float, output.split())
    return seconds, megabytes


def large_meshes() -> Section:
    """A row for each body and size."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for size in SIZES:
            for name in BODIES:
                path, triangles = fine_file(Path(folder), name, size)
                costs = [cost_of(path) for _ in range(RUNS)]
                seconds, megabytes = (median(cost) for cost in zip(*costs, strict=True))
                targets = (
                    Target("CPU, s", seconds, SECONDS),
                    Target("MB", megabytes, MEGABYTES),
                )
                cells = {"triangles": triangles, "CPU, s": seconds, "MB": megabytes}
                rows.append(Row(f"{name}, {triangles} triangles", cells, targets))
    return Section(
        "large_meshes", "Large meshes of small hulls", WHOLE.format(RUNS), tuple(rows)
    )


def ratio_to_trimesh(part: Part) -> float:
    """Median time of an estimate from arrays over that of trimesh."""
    vertices = part.surface_vertices
    triangles = part.surface_triangles
    ratios = []
    gc.collect()
    gc.freeze()
    for _ in range(ROUNDS + 1):
        mesh = Trimesh(vertices, triangles, process=False)
        gc.collect()
        _, own_seconds = timed(
            lambda: estimate(part_from_mesh(vertices, triangles), "split")
        )
        begin = time.process_time()
        compute_stable_poses(mesh, n_samples=1)
        ratios.append(own_seconds / (time.process_time() - begin))
    gc.unfreeze()
    return median(ratios[1:])  # the first loads kernels


def beside_trimesh(parts: Sequence[Part]) -> Section:
    """One row for all files."""
    ratios = []
    for part in parts:
        ratios.append(ratio_to_trimesh(part))
        print(f"{part.part_id}: {ratios[-1]:.2f} of trimesh", file=sys.stderr)
    slower = sum(ratio > 1.0 for ratio in ratios)
    cells = {
        "files": len(ratios),
        "slower": slower,
        "median ratio": median(ratios),
        "largest ratio": max(ratios),
    }
    row = Row(
        "real files", cells, (Target("largest ratio", cells["largest ratio"], 1.0),)
    )
    return Section(
        "beside_trimesh", "Files beside trimesh", BESIDE.format(ROUNDS), (row,)
    )


def sections(folders: Sequence[Path]) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    yield large_meshes()
    parts = [part for _, part in loaded(files_in(folders))]
    if parts:
        yield beside_trimesh(parts)


if __name__ == "__main__":
    parser = benchmark_parser("lab.benchmarks.meshes", __doc__)
    parser.add_argument("files", nargs="*", type=Path, help="files and folders")
    run_benchmark(parser, lambda options: sections(options.files))
