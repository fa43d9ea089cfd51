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

"""Nothing depends on how a part is turned in its own frame.

Turning rounds coordinates by some 4e-16 of the size. A face as narrow as 1e-3 radii
then leans by 4e-13, and so do heights, margins and areas; sums over some hundred faces
stay below 1e-11. Components that meet EAE and MEAE at 1e-4 sr have shares 1e-9 off at
the most.
"""

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from lab.bodies import shapes
from lab.bodies.samples import REGULAR_SOLIDS
from lab.bodies.variants import moved, rotation
from ros_pose_stats import estimate, part_from_mesh, resting_poses
from ros_pose_stats.core.shapes import demo_parts
from tests.answers import METHODS
from tests.matching import downs

BODIES = {  # and how often each is turned
    "cube": (shapes.box(2.0, 2.0, 2.0), 12),
    "box": (shapes.box(1.0, 2.0, 3.0), 12),
    "hexagonal prism": (shapes.prism(6, 1.0, 1.3), 12),
    "tetrahedron": (REGULAR_SOLIDS["tetrahedron"], 12),
    "octahedron": (REGULAR_SOLIDS["octahedron"], 12),
    "cylinder": (shapes.cylinder(48, 1.0, 0.7), 10),
    "ellipsoid": (
        shapes.hull_mesh(shapes.ellipsoid_points(150, 1, (3.0, 2.0, 1.5))),
        10,
    ),
    "clamp": (demo_parts.DEMO_PARTS["clamp"](), 6),
    "bolt": (demo_parts.DEMO_PARTS["hex_bolt"](), 6),
}
OF_EITHER = {("bolt", "split"): 4.9e-4}
"""Share of the sphere of two facets in a mirror plane: each is given to one of the
flats that it leans to alike, and rounding says to which.
"""

EXACT = ("rolls", "yaw_symmetry", "group_size")
LENGTHS = ("height", "top", "barrier")


class Answer:
    """Poses of a body, keyed by the set of its stable faces, in the numbering of
    another body.
    """

    def __init__(self, surface, tolerance, number=None):
        part = part_from_mesh(*surface)
        self.part = part
        self.tolerance = tolerance
        self.faces = downs(resting_poses(part, 0.0, round_sides=0).poses)
        self.number = (
            np.arange(len(self.faces)) if number is None else number(self.faces)
        )
        self.poses = {
            self.key(pose): pose
            for pose in resting_poses(part, tolerance, round_sides=0).poses
        }

    def key(self, pose):
        return frozenset(self.number[list(pose.members)].tolist())

    def groups(self):
        groups = {}
        for key, pose in self.poses.items():
            groups.setdefault(pose.group, set()).add(key)
        return {frozenset(keys) for keys in groups.values()}

    def probabilities(self, method):
        statistics = estimate(
            self.part, method, cluster_tolerance=self.tolerance, round_sides=0
        )
        return {self.key(pose): pose.probability for pose in statistics.poses}


def numbering(faces, turn):
    """Numbers the faces of a turned body as those that they were."""

    def number(turned):
        gap, nearest = cKDTree(faces @ turn.T).query(turned)
        assert gap.max() < 1e-11
        assert np.array_equal(np.sort(nearest), np.arange(len(faces)))
        return nearest

    return number


@pytest.mark.parametrize("tolerance", [0.0, 0.0025])
@pytest.mark.parametrize("name", BODIES)
def test_poses_groups_and_probabilities(name, tolerance):
    surface, turns = BODIES[name]
    size = np.ptp(surface[0])
    plain = Answer(surface, tolerance)
    expected = {method: plain.probabilities(method) for method in METHODS}
    for seed in range(turns):
        turn = rotation(seed)
        turned = Answer(moved(surface, turn), tolerance, numbering(plain.faces, turn))
        assert turned.poses.keys() == plain.poses.keys()
        assert turned.groups() == plain.groups()
        for key, pose in plain.poses.items():
            partner = turned.poses[key]
            for field in EXACT:
                assert getattr(partner, field) == getattr(pose, field)
            for field in LENGTHS:
                assert getattr(partner, field) == pytest.approx(
                    getattr(pose, field), abs=1e-11 * size
                )
            assert partner.margin == pytest.approx(pose.margin, abs=1e-11)
            # The angle of opposite faces is the root of what rounding leaves of the
            # chord.
            assert partner.spread == pytest.approx(pose.spread, abs=1e-7)
        for method in METHODS:
            bound = OF_EITHER.get((name, method), 1e-9)
            assert turned.probabilities(method) == pytest.approx(
                expected[method], abs=bound
            )


def test_a_face_with_a_hole_that_the_file_lacks_is_closed_in_every_frame():
    """A plate, its upper face missing: at 45 degrees two components of its normal are
    equal.
    """
    angles = np.pi * np.arange(24) / 12.0
    rims = [
        (r * np.cos(a), r * np.sin(a), z)
        for r, z in ((0.5, 0.0), (1.0, 0.0), (1.0, 0.5), (0.5, 0.5))
        for a in angles
    ]
    corner = np.arange(24)
    next_corner = (np.arange(24) + 1) % 24
    triangles = np.vstack(
        [
            np.column_stack(corners)
            for k, j in ((0, 24), (24, 48), (72, 0))
            for corners in (
                (k + corner, k + next_corner, j + next_corner),
                (k + corner, j + next_corner, j + corner),
            )
        ]
    )
    leaning = Rotation.align_vectors([[1.0, -1.0, 0.0]], [[0.0, 0.0, np.sqrt(2.0)]])[0]
    for degrees in range(0, 90, 3):
        turn = leaning * Rotation.from_euler("z", degrees, degrees=True)
        part = part_from_mesh(turn.apply(rims), triangles, unit="cm")
        assert [warning.code for warning in part.warnings] == ["HOLES_CLOSED"]
