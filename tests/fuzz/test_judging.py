"""That the judges of fuzzed meshes would notice what they look for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, resting_poses, shapes
from ros_pose_stats.errors import MeshError
from ros_pose_stats.resting.convex_body import convex_body
from tests.bodies import oblique_prism, random_polyhedron
from tests.fuzz import invariants, sameness, trial
from tests.fuzz.closeness import bend, gap, marginal, roughness, thickness, undecided
from tests.fuzz.meshes import KINDS, case
from tests.fuzz.tally import Tally, table
from tests.fuzz.trial import Outcome, attempt

PART = part_from_mesh(*random_polyhedron(12, 3))


def with_pose(statistics, **changes):
    """The same answer with one pose changed."""
    first, *others = statistics.poses
    return replace(statistics, poses=(replace(first, **changes), *others))


@pytest.mark.parametrize("kind", KINDS)
def test_a_case_is_made_from_its_seed(kind):
    one, other = case(kind, 7), case(kind, 7)
    assert repr(one.options) == repr(other.options)
    if isinstance(one.vertices, np.ndarray) and one.vertices.dtype.kind == "f":
        assert np.array_equal(one.vertices, other.vertices, equal_nan=True)


def test_a_sound_answer_has_no_faults():
    assert list(invariants.faults(PART, np.random.default_rng(1))) == []
    assert list(sameness.differences(PART, np.random.default_rng(1))) == []


@pytest.mark.parametrize("value", [np.nan, -1e-9, 2.0, np.inf])
def test_a_wrong_probability_is_noticed(value):
    found = with_pose(estimate(PART), probability=value)
    assert list(invariants.statistics_faults(found, len(found.poses)))


def test_a_missing_pose_and_a_wrong_order_are_noticed():
    found = estimate(PART)
    assert list(invariants.statistics_faults(found, len(found.poses) + 1))
    turned = replace(found, poses=found.poses[::-1])
    assert any("first" in line for line in
               invariants.statistics_faults(turned, len(found.poses)))


@pytest.mark.parametrize("changes", [
    {"height": np.nan}, {"margin": -1e-3}, {"barrier": np.inf}, {"height": 1e3}, {"index": 7},
    {"members": (0, 1)}, {"down": np.array((1.0, 0.0, 1e-3))}, {"position": np.full(3, np.nan)}])
def test_a_wrong_pose_is_noticed(changes):
    resting = resting_poses(PART, 0.0)
    first, *others = resting.poses
    assert list(invariants.pose_faults(resting)) == []
    wrong = replace(resting, poses=(replace(first, **changes), *others))
    assert list(invariants.pose_faults(wrong))


def test_json_that_cannot_be_written_is_noticed():
    found = estimate(PART)
    assert list(invariants.json_faults(found)) == []
    down = with_pose(found, down=np.array((np.nan, 0.0, 1.0)))
    assert list(invariants.json_faults(down))


@pytest.mark.parametrize(("name", "value"), [
    ("probability", 1e-6), ("height", 1e-6), ("margin", 1e-6), ("barrier", 1e-6), ("top", 1e-6)])
def test_a_difference_is_noticed(name, value):
    found = estimate(PART)
    other = with_pose(found, **{name: getattr(found.poses[0], name) + value})
    same = sameness.Change("as given", PART, np.eye(3), 1.0)
    assert sameness.difference(found, found, same, 1e-9) == ""
    assert sameness.difference(found, other, same, 1e-9).startswith(f"{name} differs")
    fewer = replace(found, poses=found.poses[1:])
    assert "poses became" in sameness.difference(found, fewer, same, 1e-9)


def test_little_is_excused():
    assert undecided(PART) == ""
    assert sameness.allowed(PART) < 2e-9
    assert marginal(PART) > 1e-3
    assert roughness(convex_body(PART, 0)) < 1e-14
    assert bend(convex_body(PART, 0)) > 1e-3
    assert gap(PART) > 1e-2
    assert thickness(PART) > 0.1


def test_what_rounding_decides_is_excused():
    # The centre of mass is right over the rim of the base.
    leaning = part_from_mesh(*oblique_prism(2.0, 4.0))
    assert undecided(leaning) == "marginal"
    corners = shapes.box(1.0, 1.0, 1.0)[0]
    corners[0, 0] -= 1.5e-6
    bent = part_from_mesh(*shapes.hull_mesh(corners), center_of_mass=(0.1, 0.2, 0.05))
    assert undecided(bent) == "nearly coplanar"


def broken(*_):
    raise ZeroDivisionError("1 / 0")


def refusing(*_, **__):
    raise MeshError("a mesh", "none", "give one")


def test_what_goes_wrong_in_a_trial_is_a_fault(monkeypatch):
    assert attempt("polyhedron", 0).faults == ()
    assert attempt("mass: impossible", 0).refusal.startswith("MassPropertiesError: expected ")
    monkeypatch.setattr(trial, "faults", broken)
    assert attempt("polyhedron", 0).faults[0].startswith("ZeroDivisionError: 1 / 0 (broken, line")
    monkeypatch.setattr(trial, "part_from_mesh", refusing)
    found = attempt("polyhedron", 0)
    assert found.faults == ("refused: MeshError: expected a mesh",)
    monkeypatch.setattr(trial, "part_from_mesh", lambda *_, **__: PART)
    monkeypatch.setattr(trial, "faults", lambda *_: iter(()))
    assert attempt("mass: impossible", 0).faults == ("taken",)


def test_the_table_tells_all():
    tally = Tally()
    for outcome in (Outcome("plate", 3, seconds=0.5, compared="same"),
                    Outcome("plate", 4, refusal="MeshError: expected thicker", seconds=0.1),
                    Outcome("soup", 9, faults=("no", "no"), seconds=2.0)):
        tally.add(outcome)
    text = table(tally)
    assert "3 inputs, 2 taken, 1 refused, 1 failed" in text
    assert "      1  MeshError: expected thicker" in text
    assert "soup, seed 9: no\n" in text
    assert "--kind 'soup' --seed 9 --meshes 1" in text
    assert "0.500 s         3  same 1" in text
