"""Parts that roll to and fro on a rim for long: none is given up, whatever it takes."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

from ros_pose_stats import part_from_mesh, simulate
from ros_pose_stats.records import DropScene
from ros_pose_stats.simulation.drop_body import drop_body
from ros_pose_stats.simulation.drops import compute_drops, drop_rules
from ros_pose_stats.tolerances import MOST_STEPS

from ..fine_parts import surface
from .dropping import counts


@pytest.fixture(scope="module")
def cover():
    """A disc with a large hole beside its axis: upright it swings about its heaviest side."""
    disc = Manifold.cylinder(0.2, 1.0, circular_segments=96)
    hole = Manifold.cylinder(1.0, 0.4, circular_segments=96).translate((0.45, 0.0, -0.5))
    return part_from_mesh(*surface(disc - hole))


def upright(count, seed=3):
    """Directions (count, 3) that point down at release, close to those on the rim."""
    random = np.random.default_rng(seed)
    angle = random.uniform(0.0, 2.0 * np.pi, count)
    return np.stack((np.cos(angle), np.sin(angle), random.uniform(-0.02, 0.02, count)), axis=1)


def test_drops_that_roll_are_counted(cover):
    found = simulate(cover, starts=upright(40), drop_height=1e-6)
    assert found.unsettled == 0
    assert found.warnings == () or not any("UNSETTLED" in one for one in found.warnings)
    assert counts(found)[2] > 10


def test_steps_are_granted_for_progress_alone(cover):
    """The same drops with half of the steps at a time end alike, to the last bit."""
    body = drop_body(cover, 0.0025, 192)
    rules = drop_rules(DropScene(0.5, 1e-6), body.radius)
    downs = upright(6)
    usual = compute_drops(body, rules, downs)
    assert usual.pose.min() >= 0
    few = compute_drops(body, rules._replace(most_steps=MOST_STEPS // 2), downs)
    for name in ("pose", "impacts", "seconds", "energy_left"):
        np.testing.assert_array_equal(getattr(few, name), getattr(usual, name))


def test_no_drop_goes_on_for_ever(cover):
    """From such a height the energy falls by a little each time, for hours."""
    body = drop_body(cover, 0.0025, 192)
    rules = drop_rules(DropScene(0.5, 1e160), body.radius)._replace(most_steps=1000)
    assert (compute_drops(body, rules, upright(3)).pose == -1).all()
