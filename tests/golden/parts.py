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

"""The parts of the golden ring: made once, kept as arrays, written as files of every
kind.

    python -m tests.golden.parts   makes `parts.npz` anew; all answers change with it

They are kept and not made by each machine, for sines and solid modellers round
differently.
"""

import tempfile
from pathlib import Path

import numpy as np

KEPT = Path(__file__).with_name("parts.npz")


def make():
    """Surfaces by name, in millimetres: the demo parts, and twenty generated ones."""
    from lab.bodies import shapes
    from lab.bodies.catalogue_parts import random_part
    from lab.bodies.random_polyhedra import random_polyhedron
    from lab.bodies.variants import moved, rotation
    from ros_pose_stats import load_part
    from ros_pose_stats.core.shapes.demo_parts import write_demo_parts

    surfaces = {}
    with tempfile.TemporaryDirectory() as folder:
        for file in write_demo_parts(folder):
            part = load_part(file, unit="mm")
            surfaces[file.stem] = 1e3 * part.surface_vertices, part.surface_triangles
    turn = rotation(5)
    box = shapes.box(10.0, 20.0, 30.0)
    half = np.linspace(0.0, np.pi, 49)
    arch = np.column_stack((10.0 * np.cos(half), 10.0 * np.sin(half)))
    ball = shapes.sphere_points(400, 3) * 10.0
    ball[:, 2] = np.maximum(ball[:, 2], -7.0)
    surfaces |= {
        "cube": shapes.box(10.0, 10.0, 10.0),
        "turned_cube": moved(shapes.box(10.0, 10.0, 10.0), turn, (30.0, -2.0, 7.0)),
        "octahedron": moved(shapes.octahedron(), turn, scale=12.0),
        "needle": shapes.box(100.0, 0.1, 0.2),
        "open_box": (box[0], np.delete(box[1], [0, 3], axis=0)),
        "drum": moved(shapes.prism(24, 10.0, 13.0), turn),
        "fine_drum": shapes.prism(64, 10.0, 10.0),
        "pebble": shapes.hull_mesh(shapes.ellipsoid_points(300, 1, (10.0, 8.0, 6.0))),
        "half_cylinder": shapes.hull_mesh(
            np.vstack(
                [np.column_stack((arch, np.full(len(arch), z))) for z in (-8.0, 8.0)]
            )
        ),
        "cut_ball": shapes.hull_mesh(ball),
    }
    for number in range(4):
        part = random_polyhedron(7, number, 0.25).part()
        surfaces[f"polyhedron_{number}"] = (
            10.0 * part.surface_vertices,
            part.surface_triangles,
        )
    for number in range(6):
        surfaces[f"machined_{number}"] = random_part(2, number)
    return {
        name: (np.asarray(vertices, dtype="<f4"), np.asarray(triangles, dtype="<u2"))
        for name, (vertices, triangles) in surfaces.items()
    }


def write(folder: Path) -> list[Path]:
    """Write all kept parts as binary STL files, two of them as OBJ and PLY instead."""
    folder.mkdir(parents=True, exist_ok=True)
    with np.load(KEPT) as archive:
        names = [
            name.removesuffix(".triangles")
            for name in archive
            if name.endswith(".triangles")
        ]
        surfaces = {
            name: (archive[f"{name}.vertices"], archive[f"{name}.triangles"])
            for name in names
        }
    writers = {"drum": ("obj", _obj), "cut_ball": ("ply", _ply)}
    files = []
    for name, surface in surfaces.items():
        kind, text = writers.get(name, ("stl", _stl))
        files.append(folder / f"{name}.{kind}")
        files[-1].write_bytes(text(*surface))
    return files


def _stl(vertices, triangles):
    rows = np.zeros(
        len(triangles),
        dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")],
    )
    rows["corners"] = vertices[triangles]
    return bytes(80) + np.uint32(len(rows)).tobytes() + rows.tobytes()


def _obj(vertices, triangles):
    lines = [
        *(f"v {x} {y} {z}" for x, y, z in vertices.tolist()),
        *(f"f {a} {b} {c}" for a, b, c in (triangles.astype(int) + 1).tolist()),
    ]
    return "\n".join(lines).encode()


def _ply(vertices, triangles):
    head = (
        "ply",
        "format ascii 1.0",
        f"element vertex {len(vertices)}",
        "property float x",
        "property float y",
        "property float z",
        f"element face {len(triangles)}",
        "property list uchar int vertex_indices",
        "end_header",
    )
    lines = [
        *head,
        *(f"{x} {y} {z}" for x, y, z in vertices.tolist()),
        *(f"3 {a} {b} {c}" for a, b, c in triangles.tolist()),
    ]
    return ("\n".join(lines) + "\n").encode()


if __name__ == "__main__":
    np.savez_compressed(
        KEPT,
        **{
            f"{name}.{key}": array
            for name, pair in make().items()
            for key, array in zip(("vertices", "triangles"), pair, strict=True)
        },
    )
