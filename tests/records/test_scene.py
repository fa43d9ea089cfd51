"""The scene in one sentence, which every output gives."""

from __future__ import annotations

import math

import pytest

from ros_pose_stats import estimate, part_from_mesh, shapes, simulate
from ros_pose_stats.records.scene import describe_scene

PART = part_from_mesh(*shapes.box(20.0, 30.0, 40.0), unit="mm")


@pytest.mark.parametrize(("height", "radius", "sentence"), [
    (0.582, 0.1, "released 582 mm above a frictionless plate, restitution 0.5"),
    (None, 0.1, "released 2 m above a frictionless plate, restitution 0.5"),
    (None, math.nan, "released 20 part radii above a frictionless plate, restitution 0.5"),
    (math.nan, 0.1, "released at any height above a frictionless plate, at any restitution"),
])
def test_it_says_how_high_and_how_bouncy(height, radius, sentence):
    assert describe_scene(0.5, height, radius) == sentence


def test_a_study_names_all_its_restitutions():
    assert describe_scene((0.2, 0.5, 0.8), 20.0) == (
        "released 20 m above a frictionless plate, restitution 0.2, 0.5 and 0.8")


def test_results_carry_it():
    dropped = simulate(PART, 10, seed=1, workers=1, restitution=0.3)
    assert dropped.scene == describe_scene(0.3, None, dropped.radius)
    assert dropped.as_dict()["scene"] == dropped.scene
    assert estimate(PART, "split", drop_height=0.25).scene.startswith("released 250 mm above")
    assert estimate(PART, "csae").scene.endswith("at any restitution")
