"""Recorded drops: what holds all along a trajectory, and that recording changes nothing."""

from __future__ import annotations

from functools import cache, lru_cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ros_pose_stats import part_from_mesh, shapes
from ros_pose_stats.kernels.drops.layout import TAPE_TIME
from ros_pose_stats.records import DropScene
from ros_pose_stats.records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_ROUND_SIDES, GRAVITY
from ros_pose_stats.resting.convex_body import convex_body
from ros_pose_stats.simulation.drop_body import drop_body
from ros_pose_stats.simulation.drops import compute_drops, drop_rules
from ros_pose_stats.simulation.record_drop import FRAMES, _record_tape, _samples, record_drop
from ros_pose_stats.simulation.simulate import simulate
from ros_pose_stats.simulation.starts import random_starts
from ros_pose_stats.tolerances import SLOW, SOFT, TOUCHING, TRUNCATION

from ..bodies import clamp_hull, random_polyhedron

NUMBERING = DEFAULT_CLUSTER_TOLERANCE, DEFAULT_ROUND_SIDES
DEEPEST = 2e-9  # radii: twice what counts as touching


@lru_cache(maxsize=1)
def bodies():
    return {
        "random 10": part_from_mesh(*random_polyhedron(10, 4)),
        "random 30": part_from_mesh(*random_polyhedron(30, 5)),
        "tetrahedron": part_from_mesh(*shapes.tetrahedron(), unit="mm"),
        "box": part_from_mesh(*shapes.box(1.0, 2.0, 3.0)),
        "prism": part_from_mesh(*shapes.prism(7, 1.0, 0.4)),
        "shifted": part_from_mesh(*shapes.box(1.0, 2.0, 3.0), center_of_mass=(0.1, -0.6, 1.2)),
        "needle": part_from_mesh(*shapes.box(1.0, 0.001, 0.002)),
        "clamp hull": part_from_mesh(*clamp_hull(), unit="mm"),
        "many corners": part_from_mesh(*random_polyhedron(5000, 6)),
    }


EVERY_BODY = pytest.mark.parametrize("name", [
    "random 10", "random 30", "tetrahedron", "box", "prism", "shifted", "needle", "clamp hull",
    "many corners"])


@cache
def trajectories(name):
    """Drops at several restitutions, one released touching the plate, one let run to rest."""
    part = bodies()[name]
    low = 0.01 * convex_body(part, 0).radius
    return [record_drop(part, k, restitution, seed=5, drop_height=low if k == 1 else None,
                        to_rest=k == 2)
            for k, restitution in enumerate((0.5, 0.2, 0.3, 0.8, 0.0))]


def phases(found):
    """Slices of the samples between two events that change velocities."""
    jumps = {event.time for event in found.events if event.kind in ("impact", "stop")}
    here = np.isin(found.times, list(jumps)) & (np.diff(found.times, prepend=-1.0) == 0.0)
    ends = [0, *np.flatnonzero(here).tolist(), len(found.times)]
    return [slice(a, b) for a, b in pairwise(ends)]


@EVERY_BODY
def test_energy(name):
    for found in trajectories(name):
        exact = 1e-12 * found.energies[0]
        assert np.diff(found.energies).max() <= exact
        for phase in phases(found):
            if found.times[phase][-1] > found.times[phase][0]:
                assert np.ptp(found.energies[phase]) <= exact


@EVERY_BODY
def test_invariants(name):
    part = bodies()[name]
    for found in trajectories(name):
        assert np.abs(np.linalg.norm(found.up, axis=1) - 1.0).max() < 1e-12
        momentum = found.angular_velocities @ part.inertia
        size = part.mass * found.radius ** 2 * np.sqrt(GRAVITY / found.radius)
        assert np.abs((found.up * momentum).sum(axis=1)).max() < 1e-9 * size


@EVERY_BODY
def test_orientation_turns_up_up(name):
    """Rounding adds up with the angle turned, some 1e4 for the needle."""
    for found in trajectories(name):
        turned = Rotation.from_quat(found.orientations).as_matrix()
        angle = np.linalg.norm(found.angular_velocities, axis=1).max() * found.times[-1]
        assert np.abs(turned[:, 2] - found.up).max() < 1e-14 * (100.0 + 3.0 * angle)
        assert np.abs(np.linalg.norm(found.orientations, axis=1) - 1.0).max() < 1e-12
        np.testing.assert_allclose(turned[0] @ found.down, (0.0, 0.0, -1.0), atol=1e-12)


@EVERY_BODY
def test_nothing_reaches_into_the_plate(name):
    part = bodies()[name]
    corners = part.vertices - part.center_of_mass
    for found in trajectories(name):
        lowest = [(height + corners @ up).min()
                  for height, up in zip(found.heights, found.up, strict=True)]
        assert min(lowest) > -DEEPEST * found.radius


@EVERY_BODY
def test_samples(name):
    """In order; every event among them; times and states in SI units."""
    for found in trajectories(name):
        assert (np.diff(found.times) >= 0.0).all()
        assert found.times[0] == 0.0 and found.events[0].kind == "release"
        assert found.times[-1] == found.events[-1].time and found.events[-1].kind == "end"
        samples = set(zip(found.times.tolist(), found.heights.tolist(), strict=True))
        assert samples.issuperset((event.time, event.height) for event in found.events)
        assert np.diff(found.times).max() <= 0.051 * np.sqrt(found.radius / GRAVITY)
        kinds = [event.kind for event in found.events]
        assert kinds.count("impact") == found.impacts


def test_times_do_not_run_past_an_event():
    """The time of an event and the span up to it, added up again, may round beyond it."""
    part, rounded_up = bodies()["box"], 0
    body = drop_body(part, 0.005, 0)
    for down in random_starts(5, 0, 20):
        tape, _ = _record_tape(body, DropScene(0.8, None, 0.005), down[None], False)
        before, after = tape[:-1, TAPE_TIME], tape[1:, TAPE_TIME]
        rounded_up += int((before + (after - before) > after).sum())
        times, _, _ = _samples(body, tape, down, 1.0 / FRAMES)
        assert (np.diff(times) >= 0.0).all()
    assert rounded_up > 0


@pytest.mark.parametrize("name", ["random 10", "tetrahedron", "box", "many corners"])
def test_the_same_drop_as_in_a_run(name):
    """Drop k of `record_drop`, of `run` and of `simulate` is one and the same."""
    part = bodies()[name]
    body = drop_body(part, *NUMBERING)
    rules = drop_rules(DropScene(0.4), body.radius)
    outcomes = compute_drops(body, rules, random_starts(11, 0, 40))
    counts = np.zeros(len(body.resting.poses), dtype=int)
    for k in range(12):
        found = record_drop(part, k, 0.4, seed=11)
        assert (found.pose, found.impacts) == (outcomes.pose[k], outcomes.impacts[k])
        assert found.events[-1].time == pytest.approx(outcomes.seconds[k], rel=1e-15)
        counts[found.pose] += 1
        poses = simulate(part, k + 1, 0.4, seed=11, workers=1).poses
        assert [pose.count for pose in sorted(poses, key=lambda p: p.index)] == counts.tolist()


@pytest.mark.parametrize("name", ["random 10", "random 30", "tetrahedron", "prism", "shifted",
                                  "box", "clamp hull"])
@pytest.mark.parametrize("restitution", [0.0, 0.2, 0.5, 0.8])
def test_the_trap_tells_where_it_comes_to_rest(name, restitution):
    """Drop by drop; on to rest, every drop settles."""
    body = drop_body(bodies()[name], 0.0, 0)
    scene = DropScene(restitution)
    starts = random_starts(21, 0, 24)
    early = compute_drops(body, drop_rules(scene, body.radius), starts)
    late = compute_drops(body, drop_rules(scene, body.radius, to_rest=True), starts)
    np.testing.assert_array_equal(late.pose, early.pose)
    assert early.trapped.any() and not late.trapped.any()
    assert (late.impacts >= early.impacts).all()


@pytest.mark.parametrize("name", ["random 10", "random 30", "tetrahedron", "prism", "shifted"])
def test_to_rest(name):
    """The same events up to the trap; in the end nothing moves, in the pose that was told."""
    part = bodies()[name]
    poses = drop_body(part, 0.0, 0).resting.poses
    for k in range(4):
        early, late = (record_drop(part, k, 0.2 * k, seed=31, to_rest=to_rest,
                                   cluster_tolerance=0.0) for to_rest in (False, True))
        before = [(e.time, e.kind, e.vertex, e.mode, e.height) for e in early.events[:-1]]
        assert before == [(e.time, e.kind, e.vertex, e.mode, e.height)
                          for e in late.events[:len(before)]]
        assert early.pose == late.pose and late.at_rest and not early.at_rest
        last, pose = late.events[-1], poses[late.pose]
        assert last.mode == "face" and last.velocity == 0.0
        assert tuple(last.angular_velocity) == (0.0, 0.0, 0.0)
        assert late.heights[-1] == pytest.approx(pose.height, abs=1e-8 * late.radius)
        np.testing.assert_allclose(-late.up[-1], pose.down, rtol=0, atol=1e-7)


@pytest.mark.parametrize("name", ["random 10", "box", "prism"])
def test_thresholds_do_not_matter(name):
    """Chaos makes the two runs independent samples of what is the same if they do not.

    Five standard deviations of each pose's difference: one false alarm in 1e5 tests.
    """
    body, drops = drop_body(bodies()[name], 0.005, 0), 1200
    usual = drop_rules(DropScene(0.5), body.radius)
    fine = usual._replace(truncation=TRUNCATION / 100.0, touching=TOUCHING / 100.0,
                          slow=SLOW / 100.0, soft=SOFT / 100.0)
    counts = [np.bincount(compute_drops(body, rules, random_starts(41, first, drops)).pose,
                          minlength=len(body.resting.poses))
              for rules, first in ((usual, 0), (fine, drops))]
    share = (counts[0] + counts[1] + 1.0) / (2.0 * drops)
    deviation = np.sqrt(2.0 * drops * share * (1.0 - np.minimum(share, 0.999)))
    assert counts[0].sum() == counts[1].sum() == drops
    assert (np.abs(counts[0] - counts[1]) <= 5.0 * deviation).all()
