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

"""What an estimate says: its method and scene, the errors to expect, and where not to
trust it.
"""

import math
import re
import sys

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import auto, estimate, estimate_all, part_from_mesh, shift_center
from tests.answers import METHODS, codes
from tests.running import refusal_of


@pytest.fixture(scope="module")
def polyhedron():
    return part_from_mesh(*random_polyhedron(9, 2))


def field(statistics, name):
    return np.array([getattr(pose, name) for pose in statistics.poses])


class TestMethods:
    def test_all_of_them_in_the_order_of_the_contract(self, polyhedron):
        answers = estimate_all(polyhedron, restitution=0.3)
        assert tuple(statistics.method for statistics in answers) == METHODS
        for statistics in answers:
            single = estimate(polyhedron, statistics.method, restitution=0.3)
            assert (
                field(statistics, "probability").tolist()
                == field(single, "probability").tolist()
            )
            assert statistics.expected_error == single.expected_error > 0.0
            assert (statistics.drops, statistics.plate_error, statistics.choice) == (
                0,
                0.05,
                "",
            )
            assert statistics.part_digest == polyhedron.digest

    def test_the_default_is_the_best_and_says_so(self, polyhedron):
        statistics = estimate(polyhedron)
        automatic = estimate(polyhedron, "auto")
        assert (
            statistics.method == automatic.method == auto(polyhedron).method == "hybrid"
        )
        assert (
            statistics.choice == automatic.choice
            and "the target is 2 points" in statistics.choice
        )

    def test_they_show_themselves_as_a_table(self, polyhedron, monkeypatch):
        statistics = estimate(polyhedron, "split")
        assert [
            int(index) for index in re.findall(r"(?m)^ +(\d+) ", str(statistics))
        ] == [pose.index for pose in statistics.poses]
        assert statistics._repr_html_() == f"<pre>{statistics}</pre>"
        assert statistics.by_index == {pose.index: pose for pose in statistics.poses}
        monkeypatch.setitem(sys.modules, "pandas", None)
        assert "expected pandas" in refusal_of(statistics.to_frame)

    def test_those_that_ignore_the_drop_height_have_none(self, polyhedron):
        height = 30.0 * estimate(polyhedron).radius
        for statistics in estimate_all(polyhedron, restitution=0.3, drop_height=height):
            assert statistics.restitution == 0.3
            assert statistics.drop_height == height or math.isnan(
                statistics.drop_height
            )
            assert (statistics.method == "split") == (statistics.drop_height == height)

    def test_one_that_is_none_is_answered_with_all_of_them(self, polyhedron):
        assert ", ".join((*METHODS, "auto")) in refusal_of(
            estimate, polyhedron, "guess"
        )


class TestErrors:
    @pytest.mark.parametrize("method", METHODS)
    def test_the_errors_of_the_poses_are_the_expected_one(self, polyhedron, method):
        """Intervals are a common multiple of them, cut off at 0 and 1; one bound holds
        all.
        """
        statistics = estimate(polyhedron, method, cluster_tolerance=0.0)
        p = field(statistics, "probability")
        errors = field(statistics, "standard_error")
        low = field(statistics, "probability_low")
        high = field(statistics, "probability_high")
        assert math.sqrt(np.mean(errors**2)) == pytest.approx(
            statistics.expected_error, rel=1e-12
        )
        assert (
            (low >= 0.0).all()
            and (low <= p).all()
            and (p <= high).all()
            and high.max() <= 1.0
        )
        reach = np.concatenate(
            (((high - p) / errors)[high < 1.0], ((p - low) / errors)[low > 0.0])
        )
        assert reach == pytest.approx(reach[0], rel=1e-9) and 1.0 < reach[0] < 1.7
        widest = reach[0] * errors.max()
        assert widest <= statistics.largest_error * 1.001 <= 3.0 * widest

    @pytest.mark.parametrize("round_sides", [0, 192])
    def test_poses_that_symmetry_makes_alike_are_equally_probable(self, round_sides):
        """Of a coin, whose rim is poured into either face by a tie."""
        coin = part_from_mesh(*shapes.prism(64, 0.01, 0.001))
        for statistics in estimate_all(coin, round_sides=round_sides):
            probability = {}
            for pose in statistics.poses:
                probability.setdefault(pose.group, []).append(pose.probability)
            assert all(len(set(alike)) == 1 for alike in probability.values()), (
                statistics.method
            )

    def test_poses_that_symmetry_makes_alike_share_an_error(self):
        statistics = estimate(part_from_mesh(*shapes.box(1.0, 2.0, 3.0)))
        for group in range(3):
            alike = [pose for pose in statistics.poses if pose.group == group]
            assert len(alike) == 2 and len({pose.standard_error for pose in alike}) == 1

    def test_they_grow_beyond_what_was_measured(self, polyhedron):
        """Of a method whose shares do not depend on the scene."""
        radius = estimate(polyhedron).radius

        def error(restitution, radii=20.0):
            return estimate(
                polyhedron, "qse", restitution=restitution, drop_height=radii * radius
            ).expected_error

        assert error(0.35 + 1e-6) == pytest.approx(error(0.35), rel=1e-4)
        high = [error(0.5, radii) for radii in (100.0, 200.0, 500.0, 1e4)]
        assert high == sorted(high) and high[-1] > 3.0 * high[0]
        bouncy = [error(restitution) for restitution in (0.992, 0.996, 0.999)]
        assert bouncy == sorted(bouncy) and bouncy[-1] > 2.0 * bouncy[0]

    def test_an_estimate_that_is_certain_expects_an_error_where_others_are_not(self):
        """PQSE gives nothing to the ends of a bar, `split` two hundredths to each."""
        bar = part_from_mesh(*shapes.box(1.0, 1.0, 2.0))
        certain, doubtful = (estimate(bar, method) for method in ("pqse", "split"))
        end = min(
            pose.probability for pose in doubtful.poses if abs(pose.down[2]) > 0.5
        )
        assert all(
            pose.probability < 1e-9 for pose in certain.poses if abs(pose.down[2]) > 0.5
        )
        assert 0.2 * end < certain.expected_error < end


class TestDoubts:
    def test_a_scene_that_nobody_measured(self, polyhedron):
        def doubted(**scene):
            return "OUTSIDE_FIT" in codes(estimate(polyhedron, "split", **scene))

        assert doubted(restitution=0.999)
        assert doubted(drop_height=300.0 * estimate(polyhedron).radius)
        assert (
            not doubted(restitution=0.98)
            and not doubted(drop_height=0.1)
            and not doubted()
        )

    def test_a_round_part_with_its_weight_beside_the_axis(self):
        """It rolls for long; the error grows with the way, and a tenth of a hair is
        none.
        """
        disc = part_from_mesh(*shapes.cylinder(192, 40e-3, 10e-3))
        answers = [
            estimate(shift_center(disc, (offset, 0.0, 0.0)), "split")
            for offset in (0.0, 1e-6, 1e-3, 4e-3)
        ]
        assert ["OUTSIDE_FIT" in codes(statistics) for statistics in answers] == [
            False,
            False,
            True,
            True,
        ]
        errors = [statistics.expected_error for statistics in answers]
        assert errors[1] == pytest.approx(errors[0], rel=0.6)
        assert errors[1] < errors[2] < errors[3]

    def test_methods_that_disagree(self, polyhedron):
        """A slender leaning body on which the old estimators see a base that drops
        never find.
        """
        surface = random_polyhedron(5, 151)
        weights = np.random.default_rng(151).dirichlet(np.ones(5))
        slender = part_from_mesh(*surface, center_of_mass=weights @ surface[0])
        for part, doubted in ((slender, True), (polyhedron, False)):
            statistics = estimate(part, "csae", cluster_tolerance=0.0)
            assert ("METHODS_DISAGREE" in codes(statistics)) == doubted
