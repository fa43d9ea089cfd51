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

"""A body of each kind for tests: regular, leaning, real, random."""

from functools import lru_cache

import numpy as np

from ros_pose_stats import part_from_mesh
from ros_pose_stats.core.shapes import demo_parts

from . import shapes

REGULAR_SOLIDS = {
    "tetrahedron": shapes.tetrahedron(),
    "cube": shapes.box(2.0, 2.0, 2.0),
    "octahedron": shapes.octahedron(),
    "dodecahedron": shapes.dodecahedron(),
    "icosahedron": shapes.icosahedron(),
}


def random_polyhedron(points, seed):
    """Convex hull of normally distributed points; their seed names it."""
    return shapes.hull_mesh(np.random.default_rng(seed).standard_normal((points, 3)))


def clamp_hull():
    """Convex hull of the demo clamp, in millimetres."""
    return shapes.hull_mesh(demo_parts.DEMO_PARTS["clamp"]()[0])


def oblique_prism(shift, length):
    """Prism over the square [-1, 1]² at z = 0; the top at z = length is shifted along
    x.
    """
    square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    lower = np.column_stack((square, np.zeros(4)))
    upper = lower + np.array((shift, 0.0, length))
    return shapes.hull_mesh(np.vstack((lower, upper)))


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
