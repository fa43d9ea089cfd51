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

"""The front door of the package: its names, its error, the defaults, parts as they
travel.
"""

import copy
import math
import pickle

import numpy as np
import pytest

import ros_pose_stats
from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import (
    PoseStatsError,
    estimate,
    estimate_all,
    load_part,
    part_from_mesh,
    resting_poses,
    simulate,
)
from tests.answers import METHODS, codes, write_stl
from tests.running import refusal_of

BOX = shapes.box(0.02, 0.03, 0.04)
RADIUS = math.sqrt(0.01**2 + 0.015**2 + 0.02**2)
DOOR = {
    "DropEvent",
    "DropProgress",
    "DropScene",
    "FlipStatistics",
    "Part",
    "PoseStatistics",
    "PoseStatsError",
    "StablePose",
    "Trajectory",
    "__version__",
    "analyse_bags",
    "auto",
    "classify_orientations",
    "compare",
    "estimate",
    "estimate_all",
    "hybrid",
    "load_part",
    "outline_at",
    "part_from_mesh",
    "record_drop",
    "resting_poses",
    "sensitivity",
    "shift_center",
    "simulate",
    "simulate_flips",
    "splitting_graph",
    "suggest",
    "upright",
}


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*BOX)


class TestNames:
    def test_every_name_of_the_contract_is_there(self):
        assert set(ros_pose_stats.__all__) >= DOOR
        assert all(hasattr(ros_pose_stats, name) for name in ros_pose_stats.__all__)
        assert all(
            getattr(ros_pose_stats, name).__doc__ for name in DOOR - {"__version__"}
        )

    def test_an_unknown_name_is_an_attribute_error(self):
        with pytest.raises(
            AttributeError, match="no attribute 'estimator_of_everything'"
        ):
            ros_pose_stats.estimator_of_everything  # noqa: B018


def test_the_examples_of_the_contract(tmp_path):
    file = write_stl(tmp_path / "clamp.stl", shapes.box(20.0, 30.0, 40.0))
    part = load_part(file, unit="mm")
    statistics = estimate(
        part,
        method="combined",
        restitution=0.3,
        drop_height=0.5,
        cluster_tolerance=0.01,
    )
    assert 0.0 < statistics.poses[0].probability < 1.0
    assert isinstance(statistics.poses[0].down, np.ndarray)
    counted = simulate(
        part, drops=100, restitution=0.5, seed=7, workers=2, cluster_tolerance=0.01
    )
    assert counted.poses[0].count >= counted.poses[-1].count
    part_with_mass = part_from_mesh(
        *BOX,
        center_of_mass=(0.001, 0.0, 0.0),
        mass=0.2,
        inertia=np.diag((2e-5, 2e-5, 2e-5)),
    )
    assert (part_with_mass.center_of_mass.tolist(), part_with_mass.mass) == (
        [0.001, 0.0, 0.0],
        0.2,
    )


def test_defaults_are_those_of_the_contract(part):
    for statistics in (estimate(part), simulate(part, 20, seed=1)):
        assert (
            statistics.restitution,
            statistics.cluster_tolerance,
            statistics.round_sides,
        ) == (
            0.5,
            0.0025,
            192,
        )
        assert statistics.drop_height == pytest.approx(20.0 * RADIUS)
        assert (statistics.plate_error, statistics.unsettled, statistics.warnings) == (
            0.05,
            0,
            (),
        )
        assert statistics.version == ros_pose_stats.__version__
        assert statistics.part_digest == part.digest and statistics.seconds > 0.0


class TestScene:
    @pytest.mark.parametrize("method", ["area", "csae", "adre", "pqse", "combined"])
    def test_methods_ignore_what_they_are_blind_to(self, part, method):
        plain = estimate(part, method)
        otherwise = estimate(part, method, restitution=0.9, drop_height=3.0)
        assert [pose.probability for pose in otherwise.poses] == [
            pose.probability for pose in plain.poses
        ]
        assert math.isnan(otherwise.drop_height)

    @pytest.mark.parametrize("radii", [1e-6, 1.0, 4.99, 5.0, 20.0])
    def test_those_blind_to_the_height_warn_below_five_radii(self, part, radii):
        for statistics in estimate_all(part, drop_height=radii * estimate(part).radius):
            warned = "LOW_DROP" in codes(statistics)
            assert warned == (radii < 5.0 and statistics.method != "split"), (
                statistics.method
            )
            assert statistics.as_dict()["warnings"] == [
                warning._asdict() for warning in statistics.warnings
            ]

    @pytest.mark.parametrize("number", range(4))
    def test_the_one_that_knows_it_expects_a_larger_error_of_a_low_drop(self, number):
        part = part_from_mesh(*random_polyhedron(9, number))
        radius = estimate(part, "split").radius
        low, high = (
            estimate(part, "split", drop_height=radii * radius) for radii in (0.5, 20.0)
        )
        assert low.expected_error > high.expected_error
        assert low.largest_error > high.largest_error > high.expected_error


class TestRefusals:
    def test_the_error_says_what_was_expected_what_came_and_what_to_do(self, part):
        with pytest.raises(
            PoseStatsError, match=r"^expected .*, got .*; .+$"
        ) as refusal:
            estimate(part, restitution=1.0)
        error = refusal.value
        assert isinstance(error, ValueError)
        copy = pickle.loads(pickle.dumps(error))
        assert (type(copy), str(copy)) == (type(error), str(error))

    @pytest.mark.parametrize(
        "options",
        [
            {"restitution": "hard"},
            {"restitution": None},
            {"restitution": True},
            {"restitution": -0.01},
            {"restitution": 1.0},
            {"restitution": math.nan},
            {"drop_height": [1.0]},
            {"drop_height": math.inf},
            {"drop_height": 0.0},
            {"cluster_tolerance": "0.1"},
            {"cluster_tolerance": -1e-9},
            {"cluster_tolerance": 1.0},
            {"round_sides": 2},
            {"method": None},
            {"method": "MEAE"},
            {"method": "simulation"},
            {"method": ""},
        ],
        ids=str,
    )
    def test_options_that_are_none(self, part, options):
        refusal_of(estimate, part, **options)

    @pytest.mark.parametrize("function", [estimate, resting_poses, simulate])
    @pytest.mark.parametrize(
        "thing", [None, "clamp.stl", BOX], ids=["none", "name", "surface"]
    )
    def test_what_is_no_part(self, function, thing):
        assert "expected a Part" in refusal_of(function, thing)

    @pytest.mark.parametrize("tolerance", [-1.0, math.nan, 5.0])
    def test_a_tolerance_of_poses(self, part, tolerance):
        assert "cluster tolerance" in refusal_of(resting_poses, part, tolerance)


@pytest.mark.parametrize(
    "copied",
    [copy.deepcopy, lambda part: pickle.loads(pickle.dumps(part))],
    ids=["deepcopy", "pickle"],
)
def test_a_copy_of_a_part_is_as_read_only_and_answers_alike(part, copied):
    duplicate = copied(part)
    assert duplicate.digest == part.digest
    with pytest.raises(ValueError, match="read-only"):
        duplicate.vertices[0] = 0.0
    assert [pose.probability for pose in estimate(duplicate, METHODS[0]).poses] == [
        pose.probability for pose in estimate(part, METHODS[0]).poses
    ]
