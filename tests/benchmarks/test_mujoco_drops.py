"""Drops by MuJoCo: whether they are fit to be compared with, never how long they took."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks import bodies
from benchmarks.mujoco import choose_setting
from ros_pose_stats import part_from_mesh, resting_poses
from ros_pose_stats.resting.convex_body import convex_body
from ros_pose_stats.shapes import box
from ros_pose_stats.study import mujoco_drops as scene
from ros_pose_stats.study.mujoco_drops import Plate, contact, drop_in_mujoco, setting

RESTITUTIONS = (0.2, 0.5, 0.8)


def half_period(restitution, depth, steps):
    """Depth and restitution of the damped spring, integrated until it would pull."""
    stiffness, damping, step = contact(restitution, depth, steps)
    speed = math.sqrt(2.0 * (scene.HEIGHT - 1.0))
    x, v, deepest, dt, elapsed = 0.0, speed, 0.0, step * steps / 40_000, 0.0
    while stiffness * x + damping * v >= 0.0:
        v -= (stiffness * x + damping * v) * dt
        x += v * dt
        deepest, elapsed = max(deepest, x), elapsed + dt
    return deepest, -v / speed, elapsed / step


class TestTheContact:
    @pytest.mark.parametrize("restitution", [0.05, *RESTITUTIONS])
    def test_closed_forms_are_those_of_the_spring(self, restitution):
        deepest, bounce, steps = half_period(restitution, 0.01, 10)
        assert deepest == pytest.approx(0.01, rel=1e-3)
        assert bounce == pytest.approx(restitution, rel=2e-3)
        assert steps == pytest.approx(10.0, rel=1e-3)

    def test_deeper_is_softer_and_slower(self):
        (firm, _, short), (soft, _, long) = contact(0.5, 0.01, 10), contact(0.5, 0.02, 10)
        assert firm == pytest.approx(4.0 * soft)
        assert long == pytest.approx(2.0 * short)


def test_without_mujoco_it_says_what_is_missing(monkeypatch):
    monkeypatch.setattr(scene, "find_spec", lambda _: None)
    assert not scene.available()
    with pytest.raises(ModuleNotFoundError, match="pip install mujoco"):
        Plate(part_from_mesh(*box(1.0, 1.0, 2.0)))


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*box(1.0, 1.0, 2.0))


@pytest.fixture(scope="module")
def plate(part):
    pytest.importorskip("mujoco")
    return Plate(part)


@pytest.fixture(scope="module", params=RESTITUTIONS)
def chosen(request, plate):
    return request.param, choose_setting(plate, request.param, 0.01)


@pytest.fixture(scope="module")
def odd():
    pytest.importorskip("mujoco")
    return part_from_mesh(*bodies.random_polyhedron(10, 0)[1:])


class TestDrops:
    def test_depth_and_restitution_are_near_the_wanted_ones(self, chosen):
        wanted, setting = chosen
        assert 0.005 <= setting.penetration <= 0.02
        assert setting.restitution == pytest.approx(wanted, rel=0.15)
        assert setting.low <= setting.restitution <= setting.high

    def test_more_steps_a_contact_are_no_worse(self, chosen, plate):
        wanted, longest = chosen
        shorter = setting(plate, wanted, 0.01, 20)
        assert shorter.step < longest.step
        assert shorter.typical <= longest.typical + 0.01

    def test_a_box_comes_to_rest_on_a_face(self, chosen, plate, part):
        found = drop_in_mujoco(plate, chosen[1], 40, 1, to_rest=True)
        assert found.poses.shape == (40, 3)
        assert found.seconds > 0.0
        tilt = np.degrees(np.arccos(np.clip(np.abs(found.poses).max(axis=1), 0.0, 1.0)))
        assert (tilt < 2.0).mean() >= 0.95
        downs = np.array([pose.down for pose in resting_poses(part).poses])
        assert (np.argmax(found.poses @ downs.T, axis=1) == found.index).all()

    def test_a_decided_drop_ends_as_it_would_at_rest(self, chosen, plate):
        decided = drop_in_mujoco(plate, chosen[1], 40, 1)
        rested = drop_in_mujoco(plate, chosen[1], 40, 1, to_rest=True)
        assert decided.steps <= rested.steps
        assert (decided.index == rested.index).mean() >= 0.95

    def test_the_seed_alone_decides(self, plate, chosen):
        first, again = (drop_in_mujoco(plate, chosen[1], 3, 7) for _ in range(2))
        assert np.array_equal(first.poses, again.poses)
        assert not np.array_equal(first.poses, drop_in_mujoco(plate, chosen[1], 3, 8).poses)


class TestThePart:
    def test_mujoco_has_its_shape_and_inertia(self, odd):
        plate, radius = Plate(odd), convex_body(odd, 0).radius
        model, turn = plate.model, np.empty(9)
        plate.engine.mju_quat2Mat(turn, model.geom_quat[1])
        seen = model.mesh_vert @ turn.reshape(3, 3).T + model.geom_pos[1]
        assert seen == pytest.approx(plate.points, abs=1e-6)
        assert seen @ plate.axes.T == pytest.approx(convex_body(odd, 0).points, abs=1e-6)
        inertia = plate.axes @ np.diag(model.body_inertia[1]) @ plate.axes.T
        assert inertia == pytest.approx(odd.inertia / (odd.mass * radius**2), abs=1e-9)
        assert model.body_ipos[1] == pytest.approx(np.zeros(3))
        assert np.linalg.det(plate.axes) == pytest.approx(1.0)

    def test_levels_are_those_of_the_poses(self, odd):
        plate, poses = Plate(odd), resting_poses(odd).poses
        radius = convex_body(odd, 0).radius
        ways_out = np.array([pose.height + pose.barrier for pose in poses]) / radius
        assert plate.decided == pytest.approx(ways_out[plate.pose])
        assert (plate.rested <= plate.decided).all()
