"""The pose that a descent ends in, by an independent descent and for bodies flat on a face."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from ros_pose_stats import part_from_mesh, shapes
from ros_pose_stats.kernels.drops.layout import up_of
from ros_pose_stats.kernels.drops.trap import energy, pose_below
from ros_pose_stats.kernels.vectors import Vec3
from ros_pose_stats.simulation.drop_body import drop_body

from ...bodies import clamp_hull, moved, oblique_prism, random_polyhedron, rotation

BODIES = {
    "random 8": random_polyhedron(8, 1), "random 20": random_polyhedron(20, 2),
    "random 40": random_polyhedron(40, 3), "leaning prism": oblique_prism(1.0, 2.0),
    "prism": shapes.prism(7, 1.0, 0.4), "clamp hull": clamp_hull(),
}
FINEST = 1e-6


def prepared(surface):
    """A body with each stable face a pose of its own: its corners (C, 3) and poses' downs."""
    body = drop_body(part_from_mesh(*surface), 0.0, 0)
    corners = np.column_stack((body.arrays.x, body.arrays.y, body.arrays.z))
    downs = np.array([pose.down for pose in body.resting.poses]) @ body.axes
    return body, corners, downs


def steepest(corners, down, width):
    """Direction (3,) in which the height falls fastest, by the corners within `width`.

    The negative of the shortest vector in the hull of the corners' gradients on the sphere.
    """
    heights = corners @ down
    gradients = corners[heights > heights.max() - width]
    gradients = gradients - np.outer(gradients @ down, down)
    heavy = np.vstack((gradients.T, np.full(len(gradients), 10.0)))
    return -gradients.T @ nnls(heavy, (0.0, 0.0, 0.0, 10.0))[0]


def descend(corners, down):
    """Where a fine path that only ever goes down comes to an end (3,)."""
    step = 0.01
    while step > FINEST:
        slope = steepest(corners, down, 0.3 * step)
        size = np.linalg.norm(slope)
        ahead = down + step * slope / max(size, 1e-12)
        ahead /= np.linalg.norm(ahead)
        if size > 1e-9 and (corners @ ahead).max() < (corners @ down).max() - 1e-12:
            down = ahead
        else:
            step *= 0.5
    return down


@pytest.mark.parametrize("name", BODIES)
def test_against_a_numerical_descent(name):
    """Wherever the level is below the way out, every path down leads to the same pose."""
    body, corners, downs = prepared(BODIES[name])
    random = np.random.default_rng(12)
    compared = 0
    for k in range(400):
        if compared == 25:
            break
        down = 0.3 * random.standard_normal(3) + downs[k % len(downs)]
        down /= np.linalg.norm(down)
        pose = pose_below(body.arrays, Vec3(*-down), int(np.argmax(corners @ down)))
        if (corners @ down).max() < body.arrays.way_out[pose] - 1e-6:
            assert np.argmax(downs @ descend(corners, down)) == pose
            compared += 1
    assert compared > 15


@pytest.mark.parametrize("name", BODIES)
def test_never_above_where_it_began(name):
    """The pose found is no higher than the start, wherever that is."""
    body, corners, downs = prepared(BODIES[name])
    levels = (downs @ corners.T).max(axis=1)
    random = np.random.default_rng(13)
    for down in random.standard_normal((500, 3)):
        down = down / np.linalg.norm(down)
        pose = pose_below(body.arrays, Vec3(*-down), int(np.argmax(corners @ down)))
        assert levels[pose] <= (corners @ down).max() + 1e-12


@pytest.mark.parametrize("name", BODIES)
def test_poses_are_their_own(name):
    """From a pose, and from all around it."""
    body, corners, downs = prepared(BODIES[name])
    random = np.random.default_rng(14)
    for pose, down in enumerate(downs):
        margin = body.arrays.way_out[pose] - (corners @ down).max()
        for k in range(20):
            here = down + min(0.2 * margin, 0.1) * random.uniform(-1.0, 1.0, 3) * (k > 0)
            here /= np.linalg.norm(here)
            heights = corners @ here
            for corner in np.flatnonzero(heights > heights.max() - 1e-9):
                assert pose_below(body.arrays, Vec3(*-here), int(corner)) == pose


@pytest.mark.parametrize("noise", [0.0, 1e-16, 1e-12, 1e-9])
def test_flat_on_a_face_of_a_cube(noise):
    """2 000 cubes turned about: rounding never picks another face, whichever corner is told."""
    random = np.random.default_rng(15)
    for seed in range(84):
        body, corners, downs = prepared(moved(shapes.box(2.0, 2.0, 2.0), rotation(seed)))
        assert len(downs) == 6
        for pose, down in enumerate(downs):
            here = down + noise * random.uniform(-1.0, 1.0, 3)
            here = here / np.linalg.norm(here)
            touching = np.flatnonzero(corners @ here > (corners @ here).max() - 1e-6)
            assert len(touching) == 4
            for corner in touching:
                assert pose_below(body.arrays, Vec3(*-here), int(corner)) == pose


def test_energy():
    moment = np.array((0.1, 0.2, 0.3))
    state = np.array((2.0, 3.0, 0.0, 0.0, 1.0, 4.0, 5.0, 6.0))
    assert energy(state, moment) == pytest.approx(2.0 + 4.5 + 0.8 + 2.5 + 5.4, rel=1e-15)
    assert up_of(state) == (0.0, 0.0, 1.0)
