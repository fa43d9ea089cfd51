"""Requests whose answers must be the same on every machine, and what was answered.

`python -m tests.machines.requests FILE` writes what this machine answers; written to
`tests/machines/answers.json`, that is what others are compared with.
"""

from __future__ import annotations

import hashlib
import json
import sys
from pathlib import Path

import numpy as np

from ros_pose_stats import estimate, part_from_mesh, simulate
from ros_pose_stats.kernels.elementary import sines_cosines
from ros_pose_stats.shapes import box, hull_mesh, prism
from ros_pose_stats.shapes.random_polyhedra import normals, random_polyhedron, uniforms

KEPT = Path(__file__).with_name("answers.json")
"""What the machine answered on which the tests were last made."""

DROPS = 60
FEW = 3

METHODS = ("qse", "eae", "meae", "split")

# Without the C library's sine: a turn by no round angle about no axis of symmetry.
(_S, _T), (_C, _D) = sines_cosines(np.array([0.7, 2.1]))
TURN = np.array([[_C, -_S * _D, _S * _T], [_S, _C * _D, -_C * _T], [0.0, _T, _D]])


def turned(surface):
    """A surface in no special position, its coordinates rounded as in an STL file."""
    vertices, triangles = surface
    x, y, z = (vertices[:, :1] * TURN[0] + vertices[:, 1:2] * TURN[1]
               + vertices[:, 2:] * TURN[2] + np.array([3.1, -0.2, 0.7])).T
    return np.column_stack((x, y, z)).astype(np.float32).astype(np.float64), triangles


def pebble(points):
    """The hull of many points near an ellipsoid."""
    cloud = normals(uniforms(5, points, 0), 3 * points).reshape(points, 3)
    size = np.sqrt((cloud * cloud).sum(axis=1))
    return hull_mesh(cloud / size[:, None] * np.array([1.0, 0.8, 0.6]))


def open_box():
    """A box without two triangles beside an edge: its hull stands in for it."""
    vertices, triangles = turned(box(1.0, 2.0, 3.0))
    return vertices, np.delete(triangles, [0, 3], axis=0)


def parts():
    """Parts by name: equal moments, ties, rims, many corners, given mass properties."""
    return {
        "cube": part_from_mesh(*box(1.0, 1.0, 1.0)),
        "turned cube": part_from_mesh(*turned(box(1.0, 1.0, 1.0))),
        "octahedron": part_from_mesh(*turned(hull_mesh(np.vstack((np.eye(3), -np.eye(3)))))),
        "needle": part_from_mesh(*box(1.0, 0.001, 0.002)),
        "open box": part_from_mesh(*open_box()),
        "drum": part_from_mesh(*turned(prism(24, 1.0, 1.3))),
        "fine drum": part_from_mesh(*prism(64, 1.0, 1.0)),
        "pebble": part_from_mesh(*pebble(300)),
        "loaded": part_from_mesh(*turned(box(1.0, 2.0, 3.0)), center_of_mass=(3.3, 0.1, 0.6),
                                 mass=0.3, inertia=[[0.3, 0.02, 0.01], [0.02, 0.25, -0.03],
                                                    [0.01, -0.03, 0.2]]),
        **{f"polyhedron {number}": random_polyhedron(7, number, 0.25).part()
           for number in range(4)},
    }


def scenes():
    """How each part is dropped."""
    return {
        "bouncy": {"restitution": 0.8}, "dull": {"restitution": 0.2},
        "even": {"restitution": 0.5, "sampling": "lattice"},
        "low": {"restitution": 0.5, "drop_height": 1e-6},
        "given": {"restitution": 0.5, "drops": 16,
                  "starts": np.array([(0.1, 0.2, k - 7.5) for k in range(16)])},
        "to a target": {"restitution": 0.5, "drops": 2000, "target_error": 0.04},
    }


def counted(part, options):
    """Counts by pose and unsettled, and the bits of all that is told of single drops."""
    chunks = []
    found = simulate(part, **{"drops": DROPS, "seed": 11, **options}, on_drops=chunks.append)
    rows = zip(*map(_columns, chunks), strict=True)
    bits = [np.concatenate(column).reshape(found.drops, -1) for column in rows]
    counts = [pose.count for pose in sorted(found.poses, key=lambda pose: pose.index)]
    return [*counts, found.unsettled], bits


def answers(names=None, drops=DROPS):
    """Counts and estimates of parts, and digests of all that was computed on the way to counts.

    `part` covers the mass properties, `first` the first few drops of every scene, `drops` all of
    them. With few `drops` the rest is left out.
    """
    found = {}
    for name, part in parts().items():
        if names is not None and name not in names:
            continue
        first, whole, counts = hashlib.sha256(), hashlib.sha256(), {}
        for scene, options in scenes().items():
            few = {} if drops == DROPS else {"drops": drops}
            counts[scene], bits = counted(part, {**options, **few})
            for column in bits:
                first.update(column[:FEW].tobytes())
                whole.update(column.tobytes())
        found[name] = {"part": part.digest, "first": first.hexdigest()}
        if drops == DROPS:
            found[name].update(drops=whole.hexdigest(), counts=counts, estimates={
                method: [pose.probability for pose in sorted(
                    estimate(part, method).poses, key=lambda pose: pose.index)]
                for method in METHODS})
    return found


def _columns(chunk):
    """All that is told of some drops, by drop."""
    outcomes = chunk.outcomes
    return (chunk.downs, outcomes.pose, outcomes.impacts, outcomes.seconds,
            outcomes.energy_left, outcomes.trapped, outcomes.touched)


def main(arguments):
    """Write the answers to the file named, or those of few drops of some parts."""
    file, *names = arguments
    found = answers(names, FEW) if names else answers()
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(one)}" for name, one in found.items())
    Path(file).write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
