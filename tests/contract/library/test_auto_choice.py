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

"""`hybrid` and `auto`: drops with an estimate's help, and what each kind of request
gets.
"""

import math

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import (
    auto,
    estimate,
    hybrid,
    part_from_mesh,
    shift_center,
    simulate,
)
from tests.answers import by_index
from tests.running import refusal_of

DEFAULT_TARGET = 0.02
LEAST_DROPS = 400
DEFAULT_SEED = 1
"""The rule of the default answer, as docs/hybrid.md tells it."""


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*random_polyhedron(9, 2))


@pytest.fixture(scope="module")
def rod_in_a_cube():
    """Its weight near one axis, as of no part that an estimate was fitted to."""
    cube = shapes.box(0.01, 0.01, 0.01)
    inertia = part_from_mesh(*cube).inertia
    return part_from_mesh(*cube, mass=1.0, inertia=inertia * np.diag((1.0, 1.0, 0.1)))


def rms(values):
    return math.sqrt(np.mean(np.square(values)))


def warned(statistics, code):
    return [warning.text for warning in statistics.warnings if warning.code == code]


class TestHybrid:
    def test_its_drops_are_those_of_the_simulation(self, part):
        combined, dropped = (
            method(part, 200, 0.3, 7, workers=1) for method in (hybrid, simulate)
        )
        assert (combined.method, combined.choice) == ("hybrid", "")
        assert (
            by_index(combined, "count").tolist() == by_index(dropped, "count").tolist()
        )
        for name in (
            "drops",
            "unsettled",
            "seed",
            "drop_height",
            "part_digest",
            "restitution",
        ):
            assert getattr(combined, name) == getattr(dropped, name)
        assert by_index(combined).sum() == pytest.approx(1.0)
        assert [pose.probability for pose in combined.poses] == sorted(
            by_index(combined), reverse=True
        )

    def test_it_lies_between_estimate_and_counts_and_is_surer_than_these(self, part):
        combined, counted = (method(part, 100, seed=3) for method in (hybrid, simulate))
        guess = estimate(part, "split")
        assert combined.expected_error < counted.expected_error
        assert rms(by_index(combined) - by_index(counted)) < rms(
            by_index(guess) - by_index(counted)
        )
        widths = [
            np.mean(
                by_index(statistics, "probability_high")
                - by_index(statistics, "probability_low")
            )
            for statistics in (combined, counted)
        ]
        assert widths[0] < widths[1]
        bounds = [
            hybrid(part, drops, seed=3).largest_error for drops in (10, 300, 3000)
        ]
        assert bounds == sorted(bounds, reverse=True)

    @pytest.mark.parametrize("workers", [1, 3])
    def test_a_target_ends_it_at_the_same_drop_whatever_the_workers(
        self, part, workers
    ):
        combined = hybrid(part, 10_000, seed=1, target_error=0.02, workers=workers)
        assert 10 < combined.drops < simulate(part, seed=1, target_error=0.02).drops
        assert (
            by_index(combined).tolist()
            == by_index(hybrid(part, combined.drops, seed=1)).tolist()
        )
        assert not warned(combined, "TARGET_MISSED")
        assert (
            hybrid(part, seed=1, target_error=0.2).drops == 10
        )  # the first look is early
        for target in (0.001, 1e-200):  # the square of the latter is 0
            assert warned(
                hybrid(part, 50, seed=1, target_error=target), "TARGET_MISSED"
            )

    def test_progress_is_of_the_hybrid_and_a_stop_is_heeded(self, part):
        heard = []
        combined = hybrid(
            part,
            1_000_000,
            seed=1,
            on_progress=heard.append,
            should_stop=lambda: len(heard) > 2,
        )
        assert 0 < combined.drops < 1_000_000
        assert heard[-1].statistics().method == "hybrid"
        # What is shown may be a moment old, of fewer drops.
        assert heard[-1].expected_error >= combined.expected_error

    def test_poses_of_a_group_share_their_counts(self):
        """Pooling pairs halves the variance; the estimate does the rest."""
        box = part_from_mesh(*shapes.box(0.02, 0.03, 0.04))
        combined = hybrid(box, 300, seed=2)
        for group in {pose.group for pose in combined.poses}:
            assert (
                np.ptp(
                    [pose.probability for pose in combined.poses if pose.group == group]
                )
                < 1e-12
            )
        assert combined.expected_error < simulate(
            box, 300, seed=2
        ).expected_error / math.sqrt(2.0)
        cube = hybrid(part_from_mesh(*shapes.box(0.02, 0.02, 0.02)), 30, seed=1)
        for name in ("probability", "probability_low", "probability_high"):
            assert by_index(cube, name) == pytest.approx(1.0 / 6.0, abs=1e-9)

    def test_drops_that_contradict_the_estimate_win(self, part, rod_in_a_cube):
        combined, counted = (
            method(rod_in_a_cube, 2000, seed=1) for method in (hybrid, simulate)
        )
        assert combined.method == "simulation"
        for name in (
            "probability",
            "probability_low",
            "probability_high",
            "standard_error",
        ):
            assert by_index(combined, name).tolist() == by_index(counted, name).tolist()
        assert (combined.expected_error, combined.largest_error) == (
            counted.expected_error,
            counted.largest_error,
        )
        (line,) = warned(combined, "CONFLICT")
        worst = np.abs(
            by_index(counted) - by_index(estimate(rod_in_a_cube, "split"))
        ).argmax()
        assert (
            f"in pose {worst} most: counted {100.0 * by_index(counted)[worst]:.2f} %"
            in line
        )
        assert not warned(hybrid(part, 1000, seed=3), "CONFLICT")


class TestAuto:
    @pytest.mark.parametrize("restitution", [0.2, 0.8])
    def test_the_default_drops_beside_the_estimate_until_it_is_sure(
        self, part, restitution
    ):
        answer, with_workers = (
            auto(part, restitution=restitution, workers=workers) for workers in (1, 3)
        )
        assert (answer.method, answer.seed) == ("hybrid", DEFAULT_SEED)
        assert answer.drops >= LEAST_DROPS
        assert answer.expected_error < DEFAULT_TARGET
        for repeated in (
            with_workers,
            estimate(part, restitution=restitution),
            hybrid(part, answer.drops, restitution, DEFAULT_SEED),
        ):
            assert by_index(repeated).tolist() == by_index(answer).tolist()
            assert (
                by_index(repeated, "count").tolist()
                == by_index(answer, "count").tolist()
            )
        assert answer.choice == with_workers.choice
        assert f"with {answer.drops} drops: within" in answer.choice
        assert not warned(answer, "TARGET_MISSED")

    def test_bounds_of_the_caller_end_the_default_too(self, part):
        answer = auto(part, drops=60, seed=4)
        assert answer.drops == 60

    def test_shares_of_groups_are_as_sure_as_poses(self):
        """Both ends of a prism are one row of the table, and err together."""
        prism = part_from_mesh(*shapes.prism(6, 0.01, 0.011))
        answer = auto(prism)
        assert len(answer.poses) == 8
        ends = [pose for pose in answer.poses if pose.group_size == 2]
        assert 2.0 * ends[0].standard_error < DEFAULT_TARGET
        poses_alone = answer.drops * (answer.expected_error / DEFAULT_TARGET) ** 2
        assert answer.drops > 2.0 * poses_alone

    def test_what_the_estimator_says_of_itself_is_kept(self):
        disc = part_from_mesh(*shapes.cylinder(24, 40e-3, 10e-3))
        lopsided = shift_center(disc, (4e-3, 0.0, 0.0))
        assert warned(estimate(lopsided, "split"), "OUTSIDE_FIT")
        answer = estimate(lopsided)
        assert answer.drops and warned(answer, "OUTSIDE_FIT")

    def test_the_budget_ends_the_drops_of_a_part_that_takes_long_to_calm_down(self):
        turn = np.arange(384) * math.pi / 192.0
        # With unequal sides: a roll over equal ones is over as soon as it is certain.
        width = np.where(turn < math.pi, 0.9, 0.88)
        rim = 0.01 * np.column_stack((np.cos(turn), width * np.sin(turn)))
        oval = part_from_mesh(
            *shapes.hull_mesh(
                np.vstack([np.insert(rim, 2, level, axis=1) for level in (0.0, 0.05)])
            )
        )
        answer, with_workers = (auto(oval, workers=workers) for workers in (1, 3))
        assert 50 <= answer.drops == with_workers.drops < LEAST_DROPS
        (warning,) = warned(answer, "TARGET_MISSED")
        assert f"{answer.drops} drops" in warning
        bounds = []
        auto(oval, on_progress=lambda progress: bounds.append(progress.bound))
        assert bounds[-1] == answer.drops
        assert (
            by_index(answer, "count").tolist()
            == by_index(with_workers, "count").tolist()
        )
        solid = auto(part_from_mesh(*shapes.tetrahedron()))  # symmetry alone
        assert (solid.method, solid.drops) == (
            "split",
            0,
        ) and "Symmetry" in solid.choice

    def test_drops_that_end_as_they_begin_count_too(self):
        """Released as it touches the plate, a thin part is decided without an event."""
        vertices, triangles = shapes.prism(24, 0.01, 0.00005)
        vertices[24:, :2] *= 0.99
        thin = part_from_mesh(vertices, triangles)
        assert estimate(thin, drop_height=0.005).drops >= LEAST_DROPS

    @pytest.mark.parametrize("scene", [{"restitution": 0.9999}, {"drop_height": 1e4}])
    def test_where_drops_hardly_end_the_estimate_stands_alone(self, part, scene):
        statistics = auto(part, **scene)
        assert statistics.drops == 0 and "hardly end" in statistics.choice
        assert warned(statistics, "TARGET_MISSED")
        assert (
            by_index(statistics).tolist()
            == by_index(estimate(part, "split", **scene)).tolist()
        )

    def test_no_estimate_is_believed_before_drops_could_refute_it(self, part):
        statistics = auto(part, 0.2)
        assert (statistics.method, statistics.drops) == ("hybrid", LEAST_DROPS)
        assert "with 90 % confidence" in statistics.choice
        solid = auto(part_from_mesh(*shapes.tetrahedron()), 0.001)  # symmetry alone
        assert solid.drops == 0 and by_index(solid) == pytest.approx(0.25)
        low = auto(part, 0.2, drop_height=1.5 * statistics.radius)
        assert (low.method, low.drops) == ("hybrid", LEAST_DROPS)

    @pytest.mark.parametrize("workers", [1, 3])
    def test_drops_are_added_up_to_the_bound(self, part, workers):
        statistics = auto(part, 0.015, seed=1, workers=workers)
        assert statistics.method == "hybrid" and statistics.expected_error < 0.015
        assert statistics.warnings == estimate(part).warnings
        assert f"with {statistics.drops} drops: within" in statistics.choice
        assert (
            by_index(statistics).tolist()
            == by_index(hybrid(part, statistics.drops, seed=1)).tolist()
        )

    def test_a_conflict_is_told_and_the_target_kept_by_the_drops(self, rod_in_a_cube):
        statistics = auto(rod_in_a_cube, 0.006, seed=1)
        assert (
            statistics.method == "simulation"
            and "Drops contradict split" in statistics.choice
        )
        assert warned(statistics, "CONFLICT") and not warned(
            statistics, "TARGET_MISSED"
        )
        assert statistics.expected_error < 0.006

    def test_bounds_end_it_and_are_told(self, part):
        statistics = auto(part, 0.001, drops=60, seed=1)
        assert statistics.drops == 60 and warned(statistics, "TARGET_MISSED")
        assert warned(auto(part, 0.0005, seed=1, max_seconds=1e-6), "TIME_LIMIT")
        assert not warned(
            auto(part, 0.0005, seed=1, should_stop=lambda: True), "TIME_LIMIT"
        )


@pytest.mark.parametrize(
    "options",
    [
        {"target_error": 1.0},
        {"target_error": "small"},
        {"drops": 0},
        {"seed": -1},
        {"workers": 0},
        {"restitution": 1.0},
        {"drop_height": -1.0},
        {"cluster_tolerance": 1.0},
    ],
)
@pytest.mark.parametrize("method", [hybrid, auto])
def test_refusals(part, method, options):
    refusal_of(method, part, **options)


@pytest.mark.parametrize("seconds", [-1.0, math.nan, "long"])
def test_no_such_time_is_refused(part, seconds):
    assert "max_seconds" in refusal_of(auto, part, max_seconds=seconds)
