"""Bodies that several test files share, and ways to give the same body differently.

A surface is a pair of vertices (V, 3) and outward triangles (T, 3).
"""

from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ros_pose_stats import part_from_mesh
from ros_pose_stats.core.shapes import demo_parts
from study import shapes

REGULAR_SOLIDS = {
    "tetrahedron": shapes.tetrahedron(),
    "cube": shapes.box(2.0, 2.0, 2.0),
    "octahedron": shapes.octahedron(),
    "dodecahedron": shapes.dodecahedron(),
    "icosahedron": shapes.icosahedron(),
}
METHODS = (
    "area",
    "csae",
    "adre",
    "qse",
    "pqse",
    "nqse",
    "eae",
    "meae",
    "combined",
    "split",
)


def random_polyhedron(points, seed):
    """Convex hull of normally distributed points; their seed names it."""
    return shapes.hull_mesh(np.random.default_rng(seed).standard_normal((points, 3)))


def clamp_hull():
    """Convex hull of the demo clamp, in millimetres."""
    return shapes.hull_mesh(demo_parts.DEMO_PARTS["clamp"]()[0])


def oblique_prism(shift, length):
    """Prism over the square [-1, 1]² at z = 0; the top at z = length is shifted along x."""
    square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    lower = np.column_stack((square, np.zeros(4)))
    upper = lower + np.array((shift, 0.0, length))
    return shapes.hull_mesh(np.vstack((lower, upper)))


def rotation(seed):
    """Random rotation matrix."""
    return Rotation.random(random_state=np.random.RandomState(seed)).as_matrix()


def moved(surface, turn=None, offset=(0.0, 0.0, 0.0), scale=1.0):
    """Turned, scaled and then shifted."""
    vertices, triangles = surface
    turned = vertices if turn is None else vertices @ np.asarray(turn).T
    return turned * scale + np.asarray(offset), triangles


def size(surface):
    """Largest extent along the axes."""
    return float(np.ptp(surface[0], axis=0).max())


def in_float32(surface):
    """Coordinates as an STL file stores them."""
    vertices, triangles = surface
    return vertices.astype(np.float32).astype(np.float64), triangles


def shuffled(surface, seed):
    """Vertices and triangles in another order, each triangle from another corner."""
    random = np.random.default_rng(seed)
    vertices, triangles = surface
    order = random.permutation(len(vertices))
    mixed = np.argsort(order)[triangles][random.permutation(len(triangles))]
    start = random.integers(3, size=len(mixed))[:, None]
    return vertices[order], np.take_along_axis(
        mixed, (start + np.arange(3)) % 3, axis=1
    )


def subdivided(surface):
    """Each triangle cut into four at the middles of its edges."""
    vertices, triangles = surface
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, index = np.unique(edges, axis=0, return_inverse=True)
    middle = vertices[unique].mean(axis=1)
    a, b, c = triangles.T
    ab, bc, ca = (index.reshape(-1, 3) + len(vertices)).T
    fine = np.concatenate(
        [
            np.column_stack(corners)
            for corners in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
        ]
    )
    return np.vstack((vertices, middle)), fine


def starred(surface, seed):
    """Each triangle cut into three at a random point in it."""
    vertices, triangles = surface
    weights = np.random.default_rng(seed).dirichlet((3.0, 3.0, 3.0), len(triangles))
    inner = np.einsum("tc,tcx->tx", weights, vertices[triangles])
    a, b, c = triangles.T
    new = len(vertices) + np.arange(len(triangles))
    fine = np.concatenate(
        [
            np.column_stack(corners)
            for corners in ((a, b, new), (b, c, new), (c, a, new))
        ]
    )
    return np.vstack((vertices, inner)), fine


@lru_cache(maxsize=1)
def convex_parts():
    """Parts by name, one of a kind: regular, loaded, leaning, real, thin, random."""
    return {
        "cube": part_from_mesh(*REGULAR_SOLIDS["cube"]),
        "box, shifted centre": part_from_mesh(
            *shapes.box(1.0, 2.0, 3.0), center_of_mass=(0.1, -0.6, 1.2)
        ),
        "prism": part_from_mesh(*shapes.prism(7, 1.0, 0.4)),
        "leaning prism": part_from_mesh(*oblique_prism(3.0, 4.0)),
        "clamp hull": part_from_mesh(*clamp_hull(), unit="mm"),
        "needle": part_from_mesh(*shapes.box(1.0, 0.001, 0.002)),
        **{
            f"random {seed}": part_from_mesh(*random_polyhedron(5 + 2 * seed, seed))
            for seed in (0, 6)
        },
    }


def write_stl(path: Path, surface) -> Path:
    """Binary STL, written without the help of the package under test."""
    vertices, triangles = surface
    record = np.zeros(
        len(triangles),
        dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")],
    )
    record["corners"] = np.asarray(vertices)[triangles]
    path.write_bytes(
        bytes(80) + len(triangles).to_bytes(4, "little") + record.tobytes()
    )
    return path


def codes(found):
    """What the warnings of a part or an answer are about."""
    return [warning.partition(":")[0] for warning in found.warnings]


def counts(found):
    """Drops in each pose, by index."""
    return [pose.count for pose in sorted(found.poses, key=lambda pose: pose.index)]


def by_index(found, name="probability"):
    """A value of all poses, in the order of their numbers."""
    return np.array([getattr(pose, name) for _, pose in sorted(found.by_index.items())])
