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

"""Estimates that can be written down: symmetric bodies, boxes and prisms."""

import numpy as np
import pytest
from scipy.integrate import quad

from lab.bodies import shapes
from lab.bodies.samples import REGULAR_SOLIDS
from lab.bodies.variants import moved, rotation
from ros_pose_stats import estimate, estimate_all, part_from_mesh
from tests.answers import METHODS
from tests.matching import downs, values


def rectangle_angle(width, length, distance):
    """Solid angle of a rectangle seen from above its centre."""
    a = width / 2.0
    b = length / 2.0
    return 4.0 * np.arctan(
        a * b / (distance * np.sqrt(a * a + b * b + distance * distance))
    )


def by_axis(statistics, axis):
    """Probability of the pose that rests on the face along an axis."""
    return values(statistics.poses, "probability")[
        downs(statistics.poses) @ axis > 1.0 - 1e-9
    ]


def turned(surface, seed=1):
    """Turned and moved, so that no coordinate is round."""
    return part_from_mesh(*moved(surface, rotation(seed), (3.0, -1.0, 0.7)))


class TestEqualFaces:
    @pytest.mark.parametrize("name", REGULAR_SOLIDS)
    def test_regular_solids_rest_on_each_face_alike(self, name):
        answers = estimate_all(turned(REGULAR_SOLIDS[name]))
        assert tuple(statistics.method for statistics in answers) == METHODS
        for statistics in answers:
            probability = values(statistics.poses, "probability")
            assert (
                len(probability)
                == {
                    "tetrahedron": 4,
                    "cube": 6,
                    "octahedron": 8,
                    "dodecahedron": 12,
                    "icosahedron": 20,
                }[name]
            )
            assert probability == pytest.approx(
                1.0 / len(probability), rel=0, abs=1e-12
            )
            assert statistics.expected_error == pytest.approx(0.0, abs=1e-7)

    @pytest.mark.parametrize(("sides", "length"), [(3, 1.2), (4, 2.7), (12, 3.0)])
    def test_prisms_rest_on_each_side_and_on_each_end_alike(self, sides, length):
        axis = rotation(1)[:, 2]
        for statistics in estimate_all(
            turned(shapes.prism(sides, 1.0, length)), cluster_tolerance=0.0
        ):
            end = np.abs(downs(statistics.poses) @ axis) > 0.5
            probability = values(statistics.poses, "probability")
            assert (end.sum(), (~end).sum()) == (2, sides)
            assert np.ptp(probability[end]) < 1e-12
            assert np.ptp(probability[~end]) < 1e-12


SIZES = [(1.0, 1.0, 1.0), (4.0, 3.0, 0.5), (0.02, 0.05, 0.03)]


@pytest.mark.parametrize("size", SIZES)
class TestBox:
    """Every face of a box is stable, so that the quasi-static estimate is CSAE."""

    @staticmethod
    def expected(size, weight):
        raw = np.array([weight(*np.delete(size, k), size[k] / 2.0) for k in range(3)])
        return raw / (2.0 * raw.sum())

    @pytest.mark.parametrize(
        ("method", "weight"),
        [
            ("area", lambda width, length, distance: width * length),
            ("csae", rectangle_angle),
            ("qse", rectangle_angle),
            (
                "adre",
                lambda width, length, distance: (
                    rectangle_angle(width, length, distance) / distance
                ),
            ),
        ],
    )
    def test_weights(self, size, method, weight):
        statistics = estimate(part_from_mesh(*shapes.box(*size)), method)
        for axis, share in zip(np.eye(3), self.expected(size, weight), strict=True):
            for direction in (axis, -axis):
                assert by_axis(statistics, direction) == pytest.approx(share, rel=1e-13)

    def test_nqse_is_eq_6_of_csae(self, size):
        e = self.expected(size, rectangle_angle)
        bend = -0.874 + 8.03 * e - 16.3 * e**2 + 7.70 * e**3
        f = e + e * (1.0 - e) * bend
        statistics = estimate(part_from_mesh(*shapes.box(*size)), "nqse")
        for axis, share in zip(np.eye(3), f / (2.0 * f.sum()), strict=True):
            assert by_axis(statistics, axis) == pytest.approx(share, rel=1e-12)

    def test_combined_is_eq_9(self, size):
        part = part_from_mesh(*shapes.box(*size))
        parts = [estimate(part, name) for name in ("meae", "nqse", "combined")]
        for axis in np.vstack((np.eye(3), -np.eye(3))):
            meae, nqse, combined = (
                by_axis(statistics, axis)[0] for statistics in parts
            )
            assert combined == pytest.approx(0.75 * meae + 0.25 * nqse, rel=1e-13)


class TestSquarePrismByEnergy:
    """EAE and MEAE of a box a x a x length, from the shape of its level sets.

    With half sizes h, R(u) = h·|u|; on the face along axis i, at the polar angle θ from
    it and the azimuth φ, R = h_i cos θ + k sin θ = A cos(θ - α), with k = h_j|cos φ| +
    h_k|sin φ|, A² = h_i² + k², tan α = k/h_i. Below a level E < A lies θ < α -
    acos(E/A).
    """

    @staticmethod
    def cap_of_R(side, first, second, level):
        """Solid angle of {R < level} around one face, where it does not flow over."""

        def ring(azimuth):
            k = first * np.cos(azimuth) + second * np.sin(azimuth)
            top = np.hypot(side, k)
            rim = np.arctan2(k, side) - np.arccos(min(level / top, 1.0))
            return 1.0 - np.cos(rim)

        return 4.0 * quad(ring, 0.0, np.pi / 2.0, epsabs=1e-13, epsrel=1e-13)[0]

    @staticmethod
    def belt_of_R(half_width, half_length, level):
        """Solid angle of {R < level} around the four sides together, two ends cut
        off.
        """

        def reach(azimuth):
            k = half_width * (np.cos(azimuth) + np.sin(azimuth))
            top = np.hypot(half_length, k)
            return np.cos(np.arctan2(k, half_length) + np.arccos(min(level / top, 1.0)))

        return 8.0 * quad(reach, 0.0, np.pi / 2.0, epsabs=1e-13, epsrel=1e-13)[0]

    @staticmethod
    def disc_on_rectangle(distance, half_width, half_length, level):
        """Solid angle of {r < level} on a face: a disc cut off by the rectangle's
        sides.
        """
        disc = np.sqrt(level**2 - distance**2)

        def ring(azimuth):
            rim = min(
                disc,
                half_width / max(np.cos(azimuth), 1e-300),
                half_length / max(np.sin(azimuth), 1e-300),
            )
            return 1.0 - distance / np.hypot(distance, rim)

        corner = np.arctan2(half_length, half_width)
        kinks = [
            np.arccos(min(half_width / disc, 1.0)),
            np.arcsin(min(half_length / disc, 1.0)),
            corner,
        ]
        return (
            4.0
            * quad(ring, 0.0, np.pi / 2.0, points=kinks, epsabs=1e-13, epsrel=1e-13)[0]
        )

    def end(self, method, half_width, half_length):
        """Probability of one end."""
        a = half_width
        c = half_length
        over_the_rim = np.hypot(half_width, half_length)
        if method == "meae":
            end = 2.0 * np.pi * (1.0 - c / over_the_rim)
            rest = 4.0 * self.disc_on_rectangle(a, a, c, over_the_rim)
        else:
            end = self.cap_of_R(c, a, a, over_the_rim)
            # Of a bar the sides join first; the ends meet the belt of all four.
            rest = (
                self.belt_of_R(a, c, over_the_rim)
                if a < c
                else 4.0 * self.cap_of_R(a, a, c, over_the_rim)
            )
        return end / (2.0 * end + rest)

    @pytest.mark.parametrize("method", ["eae", "meae"])
    def test_ends(self, method):
        for ratio in (0.2, 0.9, 1.0, 1.1, 2.0, 5.0):
            statistics = estimate(part_from_mesh(*shapes.box(1.0, 1.0, ratio)), method)
            assert by_axis(statistics, np.array((0.0, 0.0, 1.0))) == pytest.approx(
                self.end(method, 0.5, ratio / 2.0), abs=1e-10
            )


class TestPerturbed:
    """PQSE: each face gives its neighbours 0.4 of the arc between them over 4 pi, by
    area.
    """

    def test_a_box(self):
        sides = (1.0, 1.1, 1.2)
        others = [
            [sides[side] for side in range(3) if side != axis] for axis in range(3)
        ]
        areas = np.array([a * b for a, b in others])
        start = np.array(
            [
                rectangle_angle(a, b, sides[axis] / 2.0) / (4.0 * np.pi)
                for axis, (a, b) in enumerate(others)
            ]
        )
        arc = [
            2.0 * np.arctan(sides[axis] / np.hypot(*others[axis])) for axis in range(3)
        ]
        statistics = estimate(part_from_mesh(*shapes.box(*sides)), "pqse")
        for axis in range(3):
            gain = sum(
                2.0
                * 0.4
                * arc[3 - axis - side]
                / (4.0 * np.pi)
                * (areas[axis] - areas[side])
                / areas.mean()
                for side in range(3)
                if side != axis
            )
            assert by_axis(statistics, np.eye(3)[axis]) == pytest.approx(
                start[axis] + gain, rel=1e-12
            )

    def test_a_face_that_gives_all_it_has_keeps_nothing(self):
        """The narrowest of a plate; rounding leaves it a share in some places only,
        and an error that moves the bound of all.
        """
        bounds = []
        for seed in range(4):
            statistics = estimate(turned(shapes.box(1.0, 1.1, 0.3), seed), "pqse")
            assert values(statistics.poses, "probability")[-2:].tolist() == [0.0, 0.0]
            bounds.append(statistics.largest_error)
        assert bounds == pytest.approx(bounds[:1] * 4, rel=1e-9)

    @pytest.mark.parametrize("height", [0.2, 0.45, 2.0])
    def test_the_facets_of_one_rim_are_one_surface(self, height):
        """A cylinder: the strip along each rim is 0.4 times the difference of base and
        side.
        """
        bases = {}
        for sides in (64, 256):
            statistics = estimate(
                part_from_mesh(*shapes.cylinder(sides, 0.5, height)),
                "pqse",
                round_sides=0,
            )
            bases[sides] = sum(
                pose.probability for pose in statistics.poses if abs(pose.down[2]) > 0.5
            )
        base = np.pi / 4.0
        side = np.pi * height
        rim = 2.0 * np.pi * 0.5 / np.hypot(0.5, height / 2.0)
        start = 1.0 - height / 2.0 / np.hypot(0.5, height / 2.0)
        gain = (
            2.0
            * 0.4
            * rim
            / (4.0 * np.pi)
            * (base - side)
            / ((2.0 * base + side) / 3.0)
        )
        assert bases[256] == pytest.approx(np.clip(start + gain, 0.0, 1.0), abs=2e-3)
        assert bases[64] == pytest.approx(bases[256], abs=0.005)
