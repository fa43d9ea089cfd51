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

"""Recorded drops: what holds all along a trajectory, and that they are the drops of a
run.
"""

from functools import cache, lru_cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lab.bodies import shapes
from lab.bodies.samples import clamp_hull, random_polyhedron
from ros_pose_stats import PoseStatsError, part_from_mesh, record_drop, resting_poses
from tests.truth.drops.recorded import EXACT, GRAVITY, outcomes

DEEPEST = 2e-9  # radii: twice what counts as touching


@lru_cache(maxsize=1)
def bodies():
    return {
        "random": part_from_mesh(*random_polyhedron(10, 4)),
        "tetrahedron": part_from_mesh(*shapes.tetrahedron(), unit="mm"),
        "shifted": part_from_mesh(
            *shapes.box(1.0, 2.0, 3.0), center_of_mass=(0.1, -0.6, 1.2)
        ),
        "needle": part_from_mesh(*shapes.box(1.0, 0.001, 0.002)),
        "clamp hull": part_from_mesh(*clamp_hull(), unit="mm"),
        "many corners": part_from_mesh(*random_polyhedron(5000, 6)),
        **dict.fromkeys(
            ("fine disc", "rolling disc"),
            part_from_mesh(*shapes.cylinder(192, 1.0, 0.4)),
        ),
    }


EVERY_BODY = pytest.mark.parametrize(
    "name",
    [
        "random",
        "tetrahedron",
        "shifted",
        "needle",
        "clamp hull",
        "many corners",
        "fine disc",
        pytest.param("rolling disc", marks=pytest.mark.long),
    ],
)  # 140 000 events before it rests


@cache
def trajectories(name):
    """Drops at several restitutions, one released touching the plate, one let run to
    rest.
    """
    part = bodies()[name]
    low = 0.01 * resting_poses(part).body.radius
    return [
        record_drop(
            part,
            k,
            restitution,
            seed=5,
            drop_height=low if k == 1 else None,
            to_rest=k == 2 and name != "fine disc",
        )
        for k, restitution in enumerate((0.5, 0.2, 0.3, 0.8, 0.0))
    ]


def phases(trajectory):
    """Slices of the samples between two events that change velocities."""
    jumps = {
        event.time for event in trajectory.events if event.kind in ("impact", "stop")
    }
    in_phase = np.isin(trajectory.times, list(jumps)) & (
        np.diff(trajectory.times, prepend=-1.0) == 0.0
    )
    ends = [0, *np.flatnonzero(in_phase).tolist(), len(trajectory.times)]
    return [slice(a, b) for a, b in pairwise(ends)]


@EVERY_BODY
def test_energy_falls_at_impacts_and_stays_between_them(name):
    for trajectory in trajectories(name):
        exact = (
            1e-10 * trajectory.energies[0]
        )  # what the series of a hundred steps leave out
        assert np.diff(trajectory.energies).max() <= exact
        for phase in phases(trajectory):
            if trajectory.times[phase][-1] > trajectory.times[phase][0]:
                assert np.ptp(trajectory.energies[phase]) <= exact


@EVERY_BODY
def test_up_stays_a_unit_vector_and_no_spin_about_it_comes_up(name):
    part = bodies()[name]
    for trajectory in trajectories(name):
        assert np.abs(np.linalg.norm(trajectory.up, axis=1) - 1.0).max() < 1e-10
        momentum = trajectory.angular_velocities @ part.inertia
        size = part.mass * trajectory.radius**2 * np.sqrt(GRAVITY / trajectory.radius)
        assert np.abs((trajectory.up * momentum).sum(axis=1)).max() < 1e-9 * size


@EVERY_BODY
def test_orientations_turn_up_up(name):
    """Rounding adds up with the angle turned, some 1e4 for the needle."""
    for trajectory in trajectories(name):
        turned = Rotation.from_quat(trajectory.orientations).as_matrix()
        angle = (
            np.linalg.norm(trajectory.angular_velocities, axis=1).max()
            * trajectory.times[-1]
        )
        assert np.abs(turned[:, 2] - trajectory.up).max() < 1e-14 * (
            100.0 + 3.0 * angle
        )
        assert (
            np.abs(np.linalg.norm(trajectory.orientations, axis=1) - 1.0).max() < 1e-12
        )
        np.testing.assert_allclose(
            turned[0] @ trajectory.down, (0.0, 0.0, -1.0), atol=1e-12
        )


@EVERY_BODY
def test_nothing_reaches_into_the_plate(name):
    corners = bodies()[name].vertices - bodies()[name].center_of_mass
    for trajectory in trajectories(name):
        lowest = [
            (height + corners @ up).min()
            for height, up in zip(trajectory.heights, trajectory.up, strict=True)
        ]
        assert min(lowest) > -DEEPEST * trajectory.radius


@EVERY_BODY
def test_samples_are_in_order_and_hold_every_event(name):
    for trajectory in trajectories(name):
        assert (np.diff(trajectory.times) >= 0.0).all()
        assert trajectory.times[0] == 0.0 and trajectory.events[0].kind == "release"
        assert (
            trajectory.times[-1] == trajectory.events[-1].time
            and trajectory.events[-1].kind == "end"
        )
        samples = set(
            zip(trajectory.times.tolist(), trajectory.heights.tolist(), strict=True)
        )
        assert samples.issuperset(
            (event.time, event.height) for event in trajectory.events
        )
        assert np.diff(trajectory.times).max() <= 0.051 * np.sqrt(
            trajectory.radius / GRAVITY
        )
        assert [event.kind for event in trajectory.events].count(
            "impact"
        ) == trajectory.impacts


def test_times_do_not_run_past_an_event():
    """The time of an event and the span up to it, added up again, may round beyond
    it.
    """
    box = part_from_mesh(*shapes.box(1.0, 2.0, 3.0))
    for drop in range(20):
        assert (np.diff(record_drop(box, drop, 0.8, seed=5).times) >= 0.0).all()


@pytest.mark.parametrize("name", ["random", "tetrahedron", "many corners"])
def test_a_recorded_drop_is_that_of_the_run(name):
    part = bodies()[name]
    run = outcomes(part, 12, 0.4, 11)
    for k in range(12):
        trajectory = record_drop(part, k, 0.4, seed=11)
        assert (trajectory.pose, trajectory.impacts) == (run.pose[k], run.impacts[k])
        assert trajectory.events[-1].time == pytest.approx(run.seconds[k], rel=1e-15)


@pytest.mark.parametrize("name", ["random", "tetrahedron", "shifted", "clamp hull"])
@pytest.mark.parametrize("restitution", [0.0, 0.2, 0.5, 0.8])
def test_a_drop_goes_on_to_rest_in_the_pose_that_was_certain_before(name, restitution):
    """The same events up to there; in the end nothing moves, on a face of that pose."""
    part = bodies()[name]
    early_ends = 0
    poses = resting_poses(part, 0.0, 0).poses
    for k in range(6):
        early, late = (
            record_drop(
                part, k, restitution, seed=31, to_rest=to_rest, interval=1e6, **EXACT
            )
            for to_rest in (False, True)
        )
        certain = [
            (e.time, e.kind, e.vertex, e.mode, e.height) for e in early.events[:-1]
        ]
        assert certain == [
            (e.time, e.kind, e.vertex, e.mode, e.height)
            for e in late.events[: len(certain)]
        ]
        assert early.pose == late.pose and late.at_rest and not early.at_rest
        early_ends += len(early.events) < len(late.events)
        last = late.events[-1]
        pose = poses[late.pose]
        assert last.mode == "face" and last.velocity == 0.0
        assert tuple(last.angular_velocity) == (0.0, 0.0, 0.0)
        assert last.height == pytest.approx(pose.height, abs=1e-8 * late.radius)
        np.testing.assert_allclose(-last.up, pose.down, rtol=0, atol=1e-7)
    assert early_ends > 0


@pytest.mark.parametrize(
    "options",
    [
        {"drop": -1},
        {"drop": 1.5},
        {"drop": True},
        {"interval": 0.0},
        {"interval": float("nan")},
        {"start": (0.0, 0.0)},
        {"start": np.eye(3)},
        {"seed": -1},
        {"restitution": 1.0},
    ],
)
def test_what_cannot_be_recorded_is_refused(options):
    with pytest.raises(PoseStatsError, match=r"^expected .*, got .*; "):
        record_drop(bodies()["tetrahedron"], **options)
