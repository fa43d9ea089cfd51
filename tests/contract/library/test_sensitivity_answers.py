"""`sensitivity` and `suggest` as their callers see them: checks, stops and refusals."""

import pytest

from lab.bodies import shapes
from ros_pose_stats import part_from_mesh, resting_poses, sensitivity, suggest
from tests.running import refusal_of

CUBE = part_from_mesh(*shapes.box(20e-3, 20e-3, 20e-3))


@pytest.fixture(scope="module")
def heavy():
    """A box that lies heavier on one end, and the poses on its two x faces."""
    part = part_from_mesh(
        *shapes.box(20e-3, 22e-3, 24e-3), center_of_mass=(0.0, 0.0, 3e-3)
    )
    return part, [
        pose.index for pose in resting_poses(part).poses if abs(pose.down[0]) > 0.99
    ]


def plain(analysis):
    """Slopes and counted changes."""
    return [
        (effect.number, effect.slope, effect.check and effect.check.value)
        for effect in analysis.effects
    ]


def test_the_same_request_has_the_same_answer_whatever_the_workers(heavy):
    part, wanted_poses = heavy
    first, two = (
        sensitivity(part, wanted_poses, drops=500, seed=3, workers=workers)
        for workers in (1, 2)
    )
    assert plain(first) == plain(two)
    assert 0 < sum(effect.check is not None for effect in first.effects) <= 5


def test_each_check_has_drops_of_its_own(heavy):
    part, wanted_poses = heavy
    single, several = (
        sensitivity(part, wanted_poses, checks=checks, drops=100, seed=3).checked
        for checks in (1, 3)
    )
    assert several[0][1] == single[0][1]
    assert all(check.trials == 100 for _, check in several)


def test_as_many_changes_are_checked_as_asked_for(heavy):
    part, wanted_poses = heavy
    for checks in (0, 2):
        analysis = sensitivity(part, wanted_poses, checks=checks, drops=50, seed=1)
        assert sum(effect.check is not None for effect in analysis.effects) == checks
    changes = [abs(effect.change) for effect in analysis.effects]
    assert changes == pytest.approx(sorted(changes, reverse=True), abs=1e-9)  # some tie


def test_a_stop_leaves_the_estimates(heavy):
    part, wanted_poses = heavy
    reports = []
    analysis = sensitivity(
        part,
        wanted_poses,
        seed=1,
        on_progress=reports.append,
        should_stop=lambda: bool(reports) and reports[-1] > 0.0,
    )
    assert all(0.0 <= share <= 1.0 for share in reports) and reports == sorted(reports)
    assert analysis.wanted == tuple(wanted_poses)


def test_nothing_is_suggested_where_nothing_can_be_gained():
    suggestion = suggest(CUBE, list(range(6)), 1e-3, drops=10, seed=1)
    assert suggestion.steps == () and suggestion.gain.value == 0.0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"wanted": [9]}, "wanted poses out of 0 to 5"),
        ({"wanted": []}, "at least one"),
        ({"wanted": [0], "step": 0.0}, "a step above 0"),
        ({"wanted": [0], "step": 1.0}, "half the part's radius"),
        ({"wanted": [0], "drops": 0}, "1 to 1000000000 drops"),
    ],
)
def test_refusals(options, words):
    assert words in refusal_of(sensitivity, CUBE, **options)


@pytest.mark.parametrize("within", [0.0, -1e-3, 1.0, float("nan")])
def test_a_bound_that_is_none_is_refused(within):
    assert "a bound above 0" in refusal_of(suggest, CUBE, [0], within)
