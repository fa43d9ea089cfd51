# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Moments of a drop that broke implementations, each a test of its own."""

from itertools import pairwise

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from lab.bodies.variants import moved, rotation
from ros_pose_stats import PoseStatsError, part_from_mesh, resting_poses, simulate
from tests.answers import counts
from tests.truth.drops.recorded import SURE, alike, light, outcomes, recordings

CUBE = shapes.box(2.0, 2.0, 2.0)
TOUCHING = 1e-9


@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.8])
def test_flat_on_a_facet(restitution):
    """Ties between the corners of a facet, decided by rounding, gave wrong faces: 40 of
    2000.
    """
    wrong = 0
    for seed in range(42):
        turn = rotation(seed)
        part = part_from_mesh(*moved(CUBE, turn, (0.3, -0.2, 0.1)))
        axes = np.vstack((turn.T, -turn.T))
        poses = outcomes(part, restitution=restitution, starts=axes, drop_height=1.001)
        downs = {pose.index: pose.down for pose in resting_poses(part).poses}
        wrong += sum(
            k < 0 or not downs[k] @ axis > 0.999999
            for k, axis in zip(poses.pose.tolist(), axes, strict=True)
        )
    assert wrong == 0


@pytest.mark.parametrize("height", [0.5, 1.0, 1.0 + 1e-12, 1.0 + 1e-9, 1.0 + 1e-6])
def test_set_down_on_every_face(height):
    """Released touching, just touching or just not."""
    part = part_from_mesh(*CUBE)
    starts = [pose.down for pose in resting_poses(part).poses]
    assert outcomes(part, starts=starts, drop_height=height).pose.tolist() == list(
        range(6)
    )


@pytest.mark.parametrize("restitution", [0.0, 0.2, 0.6])
def test_a_corner_just_hit_or_let_go_has_left(restitution):
    """A root finder that does not factor out t, t² or t³ finds the same contact for
    ever.

    Scaled: a bounce of speed u lasts 2 u in fall, and the slowest that is not stopped
    leaves with the restitution times 1e-5. Without restitution only other corners'
    impacts lift it.
    """
    let_go = 0
    for trajectory, corners in recordings(
        light(random_polyhedron(8, 1), 0.3), restitution, 40
    ):
        clearances = {}
        for event in trajectory.events:
            if event.kind in ("impact", "lift-off"):
                clearances[event.vertex] = event.time
                let_go += event.kind == "lift-off"
            if event.kind == "arrival":
                assert event.time > clearances.get(event.vertex, -1.0)
            assert corners.heights(event).min() > -TOUCHING
        assert trajectory.pose >= 0
    assert let_go > 0 or restitution > 0.0


@pytest.mark.parametrize(
    "body",
    [part_from_mesh(*random_polyhedron(8, 0)), light(random_polyhedron(8, 0), 0.3)],
    ids=["usual", "light"],
)
@pytest.mark.parametrize("restitution", [0.2, 0.8])
def test_below_the_plate_on_the_way_up_is_no_contact(body, restitution):
    """Contact is a height of at most 0 that falls; rounding leaves corners just below
    it.

    The corner that arrives is the one named, though others as close may be on their way
    up.
    """
    rising = 0
    for trajectory, corners in recordings(body, restitution, 40):
        for event in trajectory.events:
            heights = corners.heights(event)
            velocities = corners.velocities(event)
            rising += ((heights < 0.0) & (velocities > 1e-6)).sum()
            if event.kind == "arrival":
                assert (
                    velocities[event.vertex] < 0.0 and heights[event.vertex] <= TOUCHING
                )
    assert rising > 30


@pytest.mark.parametrize("start", [(1.0, 1.0, 1.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)])
def test_exact_unstable_equilibria_end_unsettled(start):
    """A cube on a corner or an edge never falls: it must end, and be told apart, not
    lost.
    """
    part = part_from_mesh(*CUBE)
    starts = np.tile(start, (3, 1)) * np.array((1.0, -1.0, 2.0))[:, None]
    for height in (0.1, 1.5, 12.0):
        statistics = simulate(part, restitution=0.5, starts=starts, drop_height=height)
        assert (statistics.drops, sum(counts(statistics)) + statistics.unsettled) == (
            3,
            3,
        )
        warned = any(warning.code == "UNSETTLED" for warning in statistics.warnings)
        assert warned == (statistics.unsettled > 0)
        probabilities = [pose.probability for pose in statistics.poses]
        assert (
            np.isnan(probabilities).all()
            if statistics.unsettled == 3
            else np.isfinite(probabilities).all()
        )
    outcome = outcomes(part, restitution=0.5, starts=starts)
    assert np.isfinite(outcome.energy_left).all() and np.isfinite(outcome.seconds).all()


def test_drops_none_of_which_comes_to_rest_are_refused():
    with pytest.raises(PoseStatsError, match="none of the first 50"):
        simulate(part_from_mesh(*CUBE), drop_height=1.5, starts=np.ones((51, 3)))


def with_twin(surface, gap):
    """The same convex body with another vertex next to its farthest one."""
    vertices = surface[0] - surface[0].mean(axis=0)
    corner = vertices[np.argmax(np.linalg.norm(vertices, axis=1))]
    across = np.cross(corner, (0.3, -0.5, 0.8))
    twin_mesh = shapes.hull_mesh(
        np.vstack((vertices, corner + gap * across / np.linalg.norm(across)))
    )
    assert len(twin_mesh[0]) == len(vertices) + 1
    return (vertices, surface[1]), twin_mesh


@pytest.mark.parametrize(("gap", "restitution"), [(1e-6, 0.5), (1e-5, 0.2)])
def test_features_smaller_than_what_counts_as_slow(gap, restitution):
    """Two corners that close are slow together; stopping both took 5 % of the energy,
    which recorded drops show, and 3000 counted ones where it moves a share by 0.05.
    """
    part, twin = (part_from_mesh(*s) for s in with_twin(random_polyhedron(10, 0), gap))
    sizes = [len(resting_poses(body, 0.0, 0).body.points) for body in (part, twin)]
    assert sizes[1] == sizes[0] + 1
    first, second = (
        simulate(body, 3000, restitution, seed)
        for seed, body in enumerate((part, twin))
    )
    assert alike(first, second) > SURE
    for trajectory, corners in recordings(twin, restitution, 40, to_rest=True):
        for previous_event, event in pairwise(trajectory.events):
            if event.kind == "stop":
                assert corners.energy(event) > (1.0 - 3e-4) * corners.energy(
                    previous_event
                )  # of three


@pytest.mark.parametrize("restitution", [0.0, 0.2])
def test_long_sequences_of_simultaneous_impacts(restitution):
    """They reach 41 impacts at 0.2, and many more on a light body: no cap near ten."""
    longest = 0
    for factor in (0.3, 0.05):
        part = light(random_polyhedron(8, 0), factor)
        for trajectory, corners in recordings(part, restitution, 30):
            length = 0
            for previous_event, event in pairwise(trajectory.events):
                length = length + 1 if event.kind == "impact" else 0
                longest = max(longest, length)
                if (
                    previous_event.kind == "impact"
                    and event.kind != "stop"
                    and event.time > previous_event.time
                ):
                    touching = corners.heights(previous_event) < 1e-10
                    assert corners.velocities(previous_event)[touching].min() > -1e-9
            assert trajectory.pose >= 0
    assert longest > 41
