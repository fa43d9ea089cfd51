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

"""Parts as an STL file stores them, also in the frame of an assembly: the same
poses.
"""

from functools import cache

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import REGULAR_SOLIDS, random_polyhedron
from lab.bodies.variants import in_float32, moved, rotation, size
from ros_pose_stats import estimate_all, part_from_mesh
from ros_pose_stats.core.shapes import demo_parts
from tests.matching import values

BODIES = {
    "cube": lambda: REGULAR_SOLIDS["cube"],
    "icosahedron": lambda: REGULAR_SOLIDS["icosahedron"],
    **{name: demo_parts.DEMO_PARTS[name] for name in ("clamp", "gear", "hex_bolt")},
    "triangular prism": lambda: shapes.prism(3, 1.0, 2.0),
    "flat cylinder": lambda: shapes.cylinder(48, 1.0, 0.2),
    "odd cylinder": lambda: shapes.cylinder(33, 9.0, 22.0),
    "random": lambda: random_polyhedron(10, 2),
}


@cache
def exact(name):
    """Surface of a body, and the estimates of all methods for it."""
    surface = BODIES[name]()
    return surface, estimate_all(part_from_mesh(*surface))


def rounded(surface, sizes_away, seed):
    """Turned (but for seed 0), moved off the origin, and rounded."""
    shift = rotation(seed)[0] * sizes_away * size(surface)
    return part_from_mesh(
        *in_float32(moved(surface, rotation(seed + 7) if seed else None, shift))
    )


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize(("sizes_away", "seed"), [(0.0, 0), (1.0, 1), (10.0, 2)])
def test_every_method_gives_the_same_poses(name, sizes_away, seed):
    surface, estimates = exact(name)
    rough = estimate_all(rounded(surface, sizes_away, seed))
    for exact_statistics, rough_statistics in zip(estimates, rough, strict=True):
        assert len(rough_statistics.poses) == len(exact_statistics.poses)
        assert np.sort(values(rough_statistics.poses, "probability")) == pytest.approx(
            np.sort(values(exact_statistics.poses, "probability")),
            abs=1e-3 if exact_statistics.method == "split" else 3e-4,
        )
        for field in ("height", "top", "barrier"):
            assert np.sort(values(rough_statistics.poses, field)) == pytest.approx(
                np.sort(values(exact_statistics.poses, field)),
                abs=1e-5 * exact_statistics.radius,
            )
