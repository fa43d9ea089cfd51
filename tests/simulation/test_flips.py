"""Kicks out of the poses: another solver, closed forms, symmetry, and drops as the limit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2_contingency

from ros_pose_stats import PoseStatsError, part_from_mesh, shapes, simulate, simulate_flips
from ros_pose_stats.kernels.drops.layout import (
    IMPACT,
    LIFT_OFF,
    STATE,
    STOP,
    TAPE,
    TAPE_EVENT,
    TAPE_STATE,
    TAPE_TIME,
    P,
    V,
    W,
    Z,
)
from ros_pose_stats.records import DropScene
from ros_pose_stats.simulation.drop_body import drop_body
from ros_pose_stats.simulation.drops import compute_motions, drop_rules
from ros_pose_stats.simulation.kicks import kicks_of
from ros_pose_stats.simulation.starts import flip_draws

from ..bodies import random_polyhedron
from ..reference.drop_solver import reference_flip

UNLIKELY = 1e-4
"""Chance at which a test of two counts fails where both are of one distribution."""


@pytest.fixture(scope="module")
def box():
    return part_from_mesh(*shapes.box(1.0, 2.0, 3.0))


def corners_of(body):
    return np.stack((body.arrays.x, body.arrays.y, body.arrays.z), axis=1)


def alike(*rows):
    """Chance of counts as different as these, out of one distribution."""
    counts = np.array(rows)
    return chi2_contingency(counts[:, counts.any(axis=0)]).pvalue


class TestKick:
    """States just after it."""

    def states(self, kick, count=4000):
        body = drop_body(part_from_mesh(*random_polyhedron(9, 6)), 0.0, 0)
        return body, kicks_of(body, kick).states(3, 0, count)

    def test_energy_and_invariants(self):
        body, states = self.states(0.4)
        resting, pose = body.resting, np.arange(len(states)) % len(body.resting.poses)
        heights = resting.equilibria.heights[resting.clusters.lowest[pose]]
        np.testing.assert_array_equal(states[:, Z], heights)
        spin, up = states[:, W:W + 3], states[:, P:P + 3]
        energy = 0.5 * states[:, V] ** 2 + 0.5 * (spin ** 2 @ body.arrays.moment)
        np.testing.assert_allclose(energy, 0.4, rtol=1e-12)
        np.testing.assert_allclose(np.sum(up * spin * body.arrays.moment, axis=1), 0.0, atol=1e-12)

    def test_points_are_uniform_on_the_contact_polygon(self):
        """Where the angular impulse is spread as over the polygon: its mean and its scatter."""
        body = drop_body(part_from_mesh(*shapes.prism(5, 1.0, 0.3)), 0.0025, 0)
        kicks, count = kicks_of(body, 1.0), 60_000
        poses = len(body.resting.poses)
        pose = np.arange(count) % poses
        points = kicks._points(pose, flip_draws(8, 0, count))
        for index in range(poses):
            face = body.resting.equilibria.faces[body.resting.clusters.lowest[index]]
            polygon = body.resting.body.polygon(face) @ body.axes
            mine = points[pose == index]
            mean, scatter = triangle_moments(polygon)
            sigma = np.sqrt(np.diag(scatter).clip(0.0) / len(mine)) + 1e-12
            assert (np.abs(mine.mean(axis=0) - mean) < 5.0 * sigma).all()
            np.testing.assert_allclose(np.cov(mine.T), scatter, atol=0.03 * scatter.max())

    def test_some_of_them_are_the_same_kicks(self):
        body, states = self.states(0.4, 100)
        np.testing.assert_array_equal(kicks_of(body, 0.4).states(3, 37, 20), states[37:57])


def triangle_moments(polygon):
    """Mean (3,) and covariance (3, 3) of uniform points of a flat polygon, by its triangles."""
    corners = np.stack([np.broadcast_to(polygon[0], polygon[2:].shape), polygon[1:-1],
                        polygon[2:]], axis=1)
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0],
                                    corners[:, 2] - corners[:, 0]), axis=1)
    share = areas / areas.sum()
    sums = corners.sum(axis=1)
    products = (np.einsum("tci,tcj->tij", corners, corners)
                + np.einsum("ti,tj->tij", sums, sums)) / 12.0
    mean = share @ sums / 3.0
    return mean, np.einsum("t,tij->ij", share, products) - np.outer(mean, mean)


@pytest.mark.parametrize(("vertices", "seed", "restitution", "kick"), [
    (6, 1, 0.5, 0.5), (10, 2, 0.2, 0.2), (8, 3, 0.8, 2.0)])
def test_first_events_against_another_solver(vertices, seed, restitution, kick):
    """Four flips each: times and states of the first events, before infinite series are cut."""
    body = drop_body(part_from_mesh(*random_polyhedron(vertices, seed)), 0.0, 0)
    rules = drop_rules(DropScene(restitution), body.radius)._replace(to_rest=True)
    kicks, resting = kicks_of(body, kick), body.resting
    for number in range(4):
        pose = np.array([number % len(resting.poses)])
        at = kicks._points(pose, flip_draws(seed, number, 1))[0]
        states = kicks.states(seed, number, 1)
        tape = np.zeros((4096, TAPE))
        compute_motions(body, rules, states, tape)
        ours = whole_events(tape[1:int(tape[0, 0])])
        theirs = reference_flip(corners_of(body), np.diag(body.arrays.moment),
                                -states[0, P:P + 3], at, kick, restitution, 3)
        assert len(theirs) > 0
        expected = [np.concatenate(((one.time, one.height, one.velocity), one.up,
                                    one.angular_velocity)) for one in theirs]
        np.testing.assert_allclose(ours[:len(expected)], expected, rtol=0, atol=1e-8)


@pytest.mark.long
@pytest.mark.parametrize("number", [1, 2, 6, 14])
def test_whole_flips_against_another_solver(number):
    """To rest on a soft plate, through some twenty events: the pose of the matrix is theirs."""
    body = drop_body(part_from_mesh(*random_polyhedron(6, 1)), 0.0, 0)
    rules = drop_rules(DropScene(0.1), body.radius)
    kicks, poses = kicks_of(body, 0.4), body.resting.poses
    at = kicks._points(np.array([number % len(poses)]), flip_draws(1, number, 1))[0]
    states = kicks.states(1, number, 1)
    theirs = reference_flip(corners_of(body), np.diag(body.arrays.moment), -states[0, P:P + 3],
                            at, 0.4, 0.1, 60)
    assert 10 < len(theirs) < 60  # it came to rest
    downs = np.array([pose.down for pose in poses]) @ body.axes
    near = -downs @ theirs[-1].up
    assert near.max() > 1.0 - 1e-6
    assert compute_motions(body, rules, states).pose[0] == near.argmax()


def whole_events(rows):
    """Time and state (n, 9) just after each event that follows the release."""
    events = []
    for row in rows:
        together = row[TAPE_EVENT] in (IMPACT, STOP) or (
            row[TAPE_EVENT] == LIFT_OFF and events and events[-1][TAPE_EVENT] == LIFT_OFF
            and row[TAPE_TIME] - events[-1][TAPE_TIME] < 1e-10)
        if together:
            events[-1] = row
        else:
            events.append(row)
    return np.array(events)[1:, [TAPE_TIME, *range(TAPE_STATE, TAPE_STATE + STATE)]]


def test_no_kick_no_flip(box):
    found = simulate_flips(box, 0.0, 50, seed=1)
    np.testing.assert_array_equal(found.transition, np.eye(6))
    assert found.flips == 300 and not found.unsettled.any()


def test_less_than_the_way_out_is_no_flip(box):
    lowest = min(pose.barrier for pose in simulate_flips(box, 0.0, 1, seed=1).poses)
    found = simulate_flips(box, 0.999 * lowest, 200, seed=2)
    np.testing.assert_array_equal(found.transition, np.eye(6))


def test_high_kicks_are_drops(box):
    """Each row, and all together, against the counts of drops from as high."""
    found = simulate_flips(box, 60.0, 500, seed=3)
    drops = simulate(box, 6000, seed=4, drop_height=60.0)
    fresh = [pose.count for pose in sorted(drops.poses, key=lambda pose: pose.index)]
    for row in (found.counts.sum(axis=0), *found.counts):
        assert alike(row, fresh) > UNLIKELY


def test_symmetric_poses_have_equal_rows(box):
    """A half turn of the box swaps the poses of two pairs; rows are equal up to that."""
    found = simulate_flips(box, 1.0, 1500, seed=5)
    assert [pose.group for pose in found.poses] == [0, 0, 1, 1, 2, 2]
    for first, second in ((0, 1), (2, 3), (4, 5)):
        row, swapped = found.counts[first], found.counts[second].reshape(3, 2)[:, ::-1].ravel()
        assert alike(row, swapped) > UNLIKELY


def test_rows_and_their_errors(box):
    found = simulate_flips(box, 0.9, 400, seed=6)
    np.testing.assert_allclose(found.transition.sum(axis=1), 1.0, rtol=1e-12)
    again = [simulate_flips(box, 0.9, 400, seed=seed).transition for seed in range(20, 50)]
    scatter = np.std(again, axis=0, ddof=1)
    # The scatter of 30 has an error of 13 %; pooled over 36 entries some 3 %.
    assert np.sqrt((scatter ** 2).mean() / (found.standard_error ** 2).mean()) == pytest.approx(
        1.0, abs=0.15)


def test_workers_and_stops_change_nothing(box):
    one, two = (simulate_flips(box, 1.0, 300, seed=7, workers=workers) for workers in (1, 2))
    np.testing.assert_array_equal(one.counts, two.counts)
    seen = []
    cut = simulate_flips(box, 1.0, 100_000, seed=7, workers=1,
                         on_progress=lambda done, _: seen.append(done),
                         should_stop=lambda: bool(seen))
    assert 0 < cut.flips == seen[-1] < 600_000
    longer = simulate_flips(box, 1.0, -(-cut.flips // 6), seed=7)
    assert (longer.counts - cut.counts).sum() == longer.flips - cut.flips
    assert (longer.counts >= cut.counts).all()


@pytest.mark.parametrize(("values", "words"), [
    ({"kick_height": -0.1}, "kick height of 0 m or more"),
    ({"kick_height": float("nan")}, "kick height of 0 m or more"),
    ({"kick_height": "high"}, "number for kick_height"),
    ({"kick_height": 1.0, "drops": 0}, "drops"),
    ({"kick_height": 1.0, "restitution": 1.0}, "restitution"),
])
def test_refusals(box, values, words):
    with pytest.raises(PoseStatsError, match=words):
        simulate_flips(box, **values)
