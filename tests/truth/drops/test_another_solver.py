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

"""Drops against a solver that shares nothing with the package's: first events, and
whole drops.

Trajectories are chaotic: each impact multiplies a deviation by up to some thirty, so
that five events are about as many as two solvers of 1e-13 can be held to 1e-8. Without
restitution, or nearly, impacts are few, and whole drops can be compared.
"""

from functools import lru_cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lab.bodies import shapes
from lab.bodies.samples import oblique_prism, random_polyhedron
from ros_pose_stats import part_from_mesh, record_drop, resting_poses
from tests.truth.drops.recorded import EXACT, GRAVITY, as_dropped, light
from tests.truth.reference.drop_solver import Body, reference_drop, released

EVENTS = 5
AGREED = 1e-8
SAME_TIME = 1e-10  # contact forces that come down to zero together


@lru_cache(maxsize=1)
def bodies():
    return {
        "random 5": part_from_mesh(*random_polyhedron(5, 3)),
        "random 10": part_from_mesh(*random_polyhedron(10, 4)),
        "random 30": part_from_mesh(*random_polyhedron(30, 5)),
        "tetrahedron": part_from_mesh(*shapes.tetrahedron()),
        "box": part_from_mesh(*shapes.box(1.0, 2.0, 3.0), unit="mm"),
        "prism": part_from_mesh(*shapes.prism(7, 1.0, 0.4)),
        "leaning prism": part_from_mesh(*oblique_prism(3.0, 4.0)),
        "needle": part_from_mesh(*shapes.box(1.0, 0.02, 0.03)),
        "plate": part_from_mesh(*shapes.box(1.0, 0.8, 0.04)),
        "shifted": part_from_mesh(
            *shapes.box(1.0, 2.0, 3.0), center_of_mass=(0.1, -0.6, 1.2)
        ),
        # Their corners let go of the plate: one after the other, and both of an edge.
        **{
            f"light {seed}": light(random_polyhedron(6 + seed % 5, seed), 0.3)
            for seed in (0, 10, 23)
        },
    }


# body, restitution, height in radii (0.01: released touching), seed of the start
CASES = [
    ("random 5", 0.0, 2.0, 1),
    ("random 10", 0.5, 20.0, 3),
    ("random 10", 0.01, 2.0, 22),
    ("random 30", 0.8, 2.0, 5),
    ("tetrahedron", 0.0, 0.01, 8),
    ("box", 0.5, 20.0, 9),
    ("box", 0.0, 2.0, 10),
    ("prism", 0.2, 0.01, 13),
    ("leaning prism", 0.5, 20.0, 14),
    ("needle", 0.2, 20.0, 16),
    ("plate", 0.0, 2.0, 18),
    ("shifted", 0.8, 2.0, 19),
    ("light 10", 0.0, 1.5, 10),
    ("light 23", 0.0, 1.5, 23),
    ("light 0", 0.0, 1.5, 0),
]


def direction(seed):
    down = np.random.default_rng(seed).standard_normal(3)
    return down / np.linalg.norm(down)


def scaled(part):
    """Points and inertia of a body of radius and mass one, and its radius."""
    return *as_dropped(part), resting_poses(part, 0.0, 0).body.radius


def whole_events(trajectory):
    """First and last row of every event between release and end.

    An arrival goes with its impacts and the stop; lift-offs go with others at the same
    time.
    """
    unit = np.sqrt(trajectory.radius / GRAVITY)
    whole = []
    for event in trajectory.events:
        last_event = whole[-1][-1] if whole else event
        simultaneous = (
            event.kind == last_event.kind == "lift-off"
            and event.time - last_event.time < SAME_TIME * unit
        )
        if event.kind in ("impact", "stop") or simultaneous:
            whole[-1].append(event)
        else:
            whole.append([event])
    return [(rows[0], rows[-1]) for rows in whole[1:-1]]


def numbers(event, radius, unit):
    """Time and state (9,) in radii and sqrt(radius / g)."""
    return np.concatenate(
        (
            (event.time / unit, event.height / radius, event.velocity * unit / radius),
            event.up,
            event.angular_velocity * unit,
        )
    )


@pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(map(str, case)))
def test_first_events(case):
    """Kinds, times and states, and the orientations.

    The turn about the vertical at release is arbitrary, what follows is not.
    """
    name, restitution, height, seed = case
    points, inertia, radius = scaled(bodies()[name])
    start = direction(seed)
    unit = np.sqrt(radius / GRAVITY)
    trajectory = record_drop(
        bodies()[name],
        start=start,
        restitution=restitution,
        to_rest=True,
        drop_height=height * radius,
    )
    begin = released(Body(points, inertia), start, height)[2:11].reshape(3, 3)
    expected = reference_drop(points, inertia, start, restitution, height, EVENTS)
    events = whole_events(trajectory)[:EVENTS]
    assert len(events) == len(expected) > 0
    kinds = {"arrival": "impact", "lift-off": "release"}
    assert [kinds[first.kind] for first, _ in events] == [
        event.kind for event in expected
    ]
    ours = np.array([numbers(last, radius, unit) for _, last in events])
    theirs = np.array([numbers(event, 1.0, 1.0) for event in expected])
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=AGREED)

    turned = Rotation.from_quat(trajectory.orientations).as_matrix()
    yaw = begin @ turned[0].T
    assert yaw[2] == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)
    for (_, last), event in zip(events, expected, strict=True):
        sample = np.flatnonzero(trajectory.times == last.time)[-1]
        np.testing.assert_allclose(
            yaw @ turned[sample], event.rotation, rtol=0, atol=AGREED
        )


@pytest.mark.parametrize(
    ("name", "restitution"),
    [
        ("random 5", 0.1),
        ("random 10", 0.0),
        *(
            pytest.param(*case, marks=pytest.mark.long)
            for case in (("random 5", 0.2), ("random 10", 0.1), ("plate", 0.0))
        ),
    ],
)
def test_whole_drops(name, restitution):
    """It comes to rest on the face of the pose that a drop is counted in."""
    part = bodies()[name]
    points, inertia, radius = scaled(part)
    poses = resting_poses(part, 0.0, 0).poses
    rested = 0
    for drop in range(2):
        trajectory = record_drop(
            part, drop, restitution, 3, 3.0 * radius, interval=1e6, **EXACT
        )
        events = reference_drop(points, inertia, trajectory.down, restitution, 3.0, 60)
        if len(events) < 60:
            gap = [np.linalg.norm(pose.down + events[-1].up) for pose in poses]
            assert trajectory.pose == np.argmin(gap) and min(gap) < 1e-6
            rested += 1
    assert rested == 2
