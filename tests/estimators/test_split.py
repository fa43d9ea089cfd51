"""The estimator that knows the scene: symmetry, continuity, ties and bounds of the scene."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import trapezoid

from ros_pose_stats import DropScene, estimate, part_from_mesh, resting_poses, shapes
from ros_pose_stats.estimators import split as module
from ros_pose_stats.estimators.energy_absorption import meae
from ros_pose_stats.estimators.fitted_inputs import rolling_inputs
from ros_pose_stats.estimators.fitted_weights import SplitFit, TanhNetwork
from ros_pose_stats.estimators.split import component_bases, component_weights, split, split_inputs
from ros_pose_stats.kernels.body.arcs import make_arcs
from ros_pose_stats.shapes.random_polyhedra import random_polyhedron


def hull(points, **properties):
    return part_from_mesh(*shapes.hull_mesh(np.asarray(points, dtype=float)), **properties)


def by_index(part, restitution=0.5, height=None, tolerance=0.0):
    return split(resting_poses(part, tolerance), DropScene(restitution, height, tolerance))


@pytest.mark.parametrize("number", range(3))
def test_without_its_weights_it_is_the_modified_energy_absorption_estimator(number, monkeypatch):
    """Eq. 8 with r, which has an implementation of its own."""
    none = SplitFit(*(TanhNetwork(bias, np.zeros(26), np.zeros((26, 1)), np.zeros(1), np.zeros(1))
                      for bias in (0.0, -300.0)))
    monkeypatch.setattr(module, "component_weights", lambda rows: component_weights(rows, [none]))
    resting = resting_poses(random_polyhedron(8, number, 0.25).part(), 0.0)
    np.testing.assert_allclose(split(resting, DropScene()), meae(resting), rtol=0, atol=1e-9)


@pytest.mark.parametrize(("of", "columns"), [(0, (11, 12)), (7, (13, 14))])
def test_what_joins_soon_by_its_definition(of, columns):
    """Up every branch: siblings' areas and holding angles, each the less the higher it joins."""
    resting = resting_poses(random_polyhedron(8, 5, 0.25).part(), 0.0)
    tree, found = resting.equilibria.arrays.tree, resting.split_features
    joins = tree.level.shape[0]
    upper = {int(child): (join, side) for join in range(joins)
             for side, child in enumerate(tree.child[join])}

    def joined(node, level, rise):
        total = 0.0
        while node in upper:
            join, side = upper[node]
            later = (tree.level[join] - level) / rise
            total += math.exp(found[join, 1 - side, of] - later)
            node = joins + 1 + join
        return total

    for join in range(joins):
        nodes = (*tree.child[join].tolist(), joins + 1 + join)
        for column, rise in zip(columns, (0.01, 0.1), strict=True):
            told = [math.log1p(joined(node, tree.level[join], rise)
                               / math.exp(found[join, row, of]))
                    for row, node in enumerate(nodes)]
            np.testing.assert_allclose(found[join, :, column], told, rtol=1e-9)


def test_a_component_of_no_depth_holds_nothing():
    rows = np.zeros((4, 26))
    rows[:, 3] = (0.0, 1e-6, 1e-3, 0.5)
    area, held = component_bases(rows)
    assert area.tolist() == [0.0] * 4
    np.testing.assert_allclose(np.exp(held), (0.0, 1e-3, 0.5, 1.0), atol=2e-3)


def test_what_a_cylinder_rolls_on():
    """Its ends are no facets of a turn, and its side is all of the 192; by solid angles."""
    resting = resting_poses(part_from_mesh(*shapes.cylinder(48, 1.0, 2.0)))
    found = rolling_inputs(resting).reshape(-1, 3, 2)
    side = 1.0 / math.sqrt(2.0)  # of the sphere, seen from the middle
    shares = found[:, :, 0]
    np.testing.assert_allclose(shares[-1, 2], side, atol=1e-3)
    assert set(np.round(shares[0, :2], 9).tolist()) <= {0.0, 1.0}
    np.testing.assert_allclose(found[:, :, 1], shares * math.log(192.0), rtol=1e-12)
    cube = resting_poses(part_from_mesh(*shapes.box(1.0, 1.1, 1.2)))
    assert not rolling_inputs(cube).any()


class TestScene:
    part = random_polyhedron(8, 3, 0.25).part()

    def test_it_matters(self):
        plain = by_index(self.part)
        assert np.abs(by_index(self.part, 0.9) - plain).max() > 0.01
        assert np.abs(by_index(self.part, 0.5, 1.2) - plain).max() > 0.001

    @pytest.mark.parametrize("step", [1e-3, 1e-5])
    def test_it_changes_the_answer_smoothly(self, step):
        for restitution in np.linspace(0.0, 0.94, 12):
            for height in np.geomspace(1.0, 90.0, 8):
                here = by_index(self.part, restitution, height)
                there = by_index(self.part, restitution + step, height * (1.0 + step))
                assert np.abs(there - here).max() < 5.0 * step

    def test_beyond_the_fit_the_nearest_counts(self):
        np.testing.assert_array_equal(by_index(self.part, 0.99), by_index(self.part, 0.999))
        np.testing.assert_array_equal(by_index(self.part, 0.5, 1e3), by_index(self.part, 0.5, 1e6))
        np.testing.assert_array_equal(by_index(self.part, 0.5, 0.1), by_index(self.part, 0.5, 0.4))

    def test_the_default_is_twenty_radii(self):
        radius = resting_poses(self.part, 0.0).body.radius
        np.testing.assert_array_equal(by_index(self.part), by_index(self.part, 0.5, 20.0 * radius))


class TestInertia:
    def test_it_matters(self):
        surface = shapes.box(1.0, 1.3, 1.7)
        plain = part_from_mesh(*surface, mass=1.0)
        moments = np.diag(plain.inertia)
        hollow = part_from_mesh(*surface, mass=1.0, inertia=np.diag(moments * (1.0, 1.0, 1.4)))
        assert np.abs(by_index(plain) - by_index(hollow)).max() > 1e-3

    def test_the_metric_is_that_of_a_sphere_where_the_moments_are_equal(self):
        """A cube's edge rolls along R = q cos x: speed² = q² sin² x + I, by hand."""
        resting = resting_poses(part_from_mesh(*shapes.box(1.0, 1.0, 1.0)), 0.0)
        body, moment = resting.body, resting.inertia
        arcs = make_arcs(body.points, body.arrays, moment, np.linalg.inv(moment))
        x = np.linspace(0.0, np.pi / 4.0, 20_001)
        q, half = body.arrays.reach[0], body.arrays.start[0]
        speed = np.sqrt((q * np.sin(x)) ** 2 + moment[0, 0])
        # Both corners have the same lever in the plane of x; across it, half an edge each way.
        same, apart = 1.0 + (q * np.sin(x)) ** 2 / moment[0, 0], half / np.sqrt(moment[0, 0])
        turn = 2.0 * np.arctan(apart / np.sqrt(same))
        np.testing.assert_allclose(arcs.whole[:, 0], trapezoid(turn, x), rtol=1e-5)
        np.testing.assert_allclose(arcs.whole[:, 1], np.trapezoid(turn * speed, x), rtol=1e-5)


class TestContinuity:
    def test_where_a_face_becomes_marginal(self):
        """A prism leans until its centre of mass crosses the base's edge, at a lean of 1."""
        def base(lean):
            square = np.array([(x, y, 0.0) for x in (-0.5, 0.5) for y in (-0.4, 0.4)])
            part = hull(np.vstack((square, square + np.array((lean, 0.0, 1.5)))))
            return sum(pose.probability for pose in
                       estimate(part, "split", cluster_tolerance=0.0).poses
                       if abs(pose.down[2]) > 0.999)

        near = [base(1.0 + step) for step in (-1e-3, -1e-5, 1e-5, 1e-3)]
        assert max(near) < 1e-3
        assert base(0.9) > 10.0 * max(near)

    def test_where_a_face_breaks_in_two(self):
        """The roof of a house, its ridge off the middle, flattens until it is one face."""
        def walls(rise, tolerance=0.005):
            low = [(x, y, z) for x in (-0.6, 0.6) for y in (-0.5, 0.5) for z in (0.0, 0.7)]
            part = hull([*low, *((x, 0.15, 0.7 + rise) for x in (-0.6, 0.6))])
            found = estimate(part, "split", cluster_tolerance=tolerance)
            return sum(pose.probability for pose in found.poses if pose.down[2] > 0.8)

        assert walls(1e-5) == pytest.approx(walls(0.0), abs=2e-3)
        for rise in (1e-6, 1e-5, 1e-4, 1e-3):  # two poses
            assert walls(rise, 0.0) == pytest.approx(walls(0.0, 0.0), abs=3e-3)

    def test_where_splits_tie(self):
        """Whichever of two saddles is the higher one by a hair."""
        def answers(step):
            part = part_from_mesh(*shapes.box(1.0, 1.0 + step, 1.5))
            resting = resting_poses(part, 0.0)
            return {tuple(np.round(pose.down).astype(int) + 0): p for pose, p in
                    zip(resting.poses, split(resting, DropScene()), strict=True)}

        one, other = answers(-1e-7), answers(1e-7)
        for down, p in one.items():
            assert other[down] == pytest.approx(p, abs=1e-4)


def test_inputs_are_finite_for_slivers_and_large_bodies():
    for part in (hull(np.random.default_rng(1).normal(size=(300, 3))),
                 part_from_mesh(*shapes.box(1.0, 1.0, 1e-3)),
                 part_from_mesh(*shapes.cylinder(512, 0.01, 0.02))):
        for tolerance in (0.0, 0.005):
            resting = resting_poses(part, tolerance)
            assert np.isfinite(split_inputs(resting, DropScene())).all()
            assert by_index(part, tolerance=tolerance).sum() == pytest.approx(1.0, abs=1e-12)


def test_it_beats_the_paper_on_bodies_that_it_was_not_fitted_to():
    """Bodies of a reference dataset: another seed than the fit's, the same kind of polyhedra."""
    from ros_pose_stats.study.dataset.dataset import shipped_dataset
    from ros_pose_stats.study.estimates import scene_estimates, square_errors
    from tests.study.tables import first_bodies

    dataset = first_bodies(shipped_dataset(0.65, "second"), 150)
    poses = [dataset.resting(number) for number in range(150)]
    for restitution, told in scene_estimates(dataset, poses).items():
        errors = {name: square_errors(told[name], dataset.simulated(restitution)).mean()
                  for name in ("split", "combined", "meae")}
        assert errors["split"] < 0.8 * min(errors["combined"], errors["meae"])
