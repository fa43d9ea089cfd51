"""A drop in frames: where it ends, and what is never shown."""

from functools import cache

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, resting_poses, simulate
from ros_pose_stats.errors import RequestError
from ros_pose_stats.resting.orientation import rotation_matrices
from ros_pose_stats.shapes.closed_forms import box, cylinder
from ros_pose_stats.simulation.frames import PAUSE, RATE, SHOWN, drop_frames, watchable_drop
from tests.bodies import clamp_hull

BODIES = {"box": box(0.04, 0.03, 0.02), "clamp": clamp_hull(),
          "cylinder": cylinder(64, 0.01, 0.03)}


@cache
def frames_of(name, drop=3, restitution=0.5):
    part = part_from_mesh(*BODIES[name])
    found = watchable_drop(part, drop, restitution, 7, None, 0.005, 0)
    resting = resting_poses(part, round_sides=0)
    return part, found, resting, drop_frames(part, found, resting)


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("restitution", [0.0, 0.5])
class TestEveryDrop:
    def test_ends_at_rest_in_the_pose_that_the_simulation_counts(self, name, restitution):
        part, found, resting, frames = frames_of(name, 3, restitution)
        counted = []
        simulate(part, 4, restitution, 7, workers=1,
                 on_drops=lambda chunk: counted.extend(chunk.outcomes.pose.tolist()))
        assert found.pose == counted[3]
        down = rotation_matrices(frames.orientations[-1:])[0].T @ (0.0, 0.0, -1.0)
        members = resting.equilibria.downs[resting.clusters.pose == found.pose]
        assert np.linalg.norm(members - down, axis=1).min() < 1e-9
        placed = (part.surface_vertices - part.center_of_mass) @ rotation_matrices(
            frames.orientations[-1:])[0].T + (0.0, 0.0, frames.heights[-1])
        assert placed[:, 2].min() == pytest.approx(0.0, abs=1e-6 * found.radius)
        assert len(frames.times) - frames.rest == round(PAUSE * RATE)

    def test_never_gains_energy(self, name, restitution):
        _, found, _, frames = frames_of(name, 3, restitution)
        scale = found.energies[0]
        assert (np.diff(found.energies) <= 1e-9 * scale).all()
        assert (np.diff(frames.energies) <= 0.0).all()
        assert frames.energies[-1] > 0.0

    def test_is_short_and_never_below_the_plate(self, name, restitution):
        part, found, _, frames = frames_of(name, 3, restitution)
        assert frames.rest <= SHOWN * RATE + 1
        assert (np.diff(frames.times) >= 0.0).all()
        corners = part.surface_vertices - part.center_of_mass
        turns = rotation_matrices(frames.orientations)
        lowest = (corners @ turns[:, 2].T).min(axis=0) + frames.heights
        assert lowest.min() > -0.01 * found.radius

    def test_the_last_step_into_rest_is_too_small_to_be_seen(self, name, restitution):
        _, found, _, frames = frames_of(name, 3, restitution)
        before, after = frames.rest - 1, frames.rest
        assert abs(frames.heights[after] - frames.heights[before]) < 0.15 * found.radius
        inner = abs(float(frames.orientations[before] @ frames.orientations[after]))
        assert 2.0 * np.arccos(min(1.0, inner)) < 0.3


def test_a_drop_that_never_settles_is_refused():
    part = part_from_mesh(*BODIES["box"])
    with pytest.raises(RequestError, match="the number of a drop"):
        watchable_drop(part, -1, 0.5, 7, None, 0.005, 0)
