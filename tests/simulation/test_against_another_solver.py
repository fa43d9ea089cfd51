"""The first events of drops against a solver that shares nothing with the package's.

Trajectories are chaotic: each impact multiplies a deviation by up to some thirty, so that five
events are about as many as two solvers of 1e-13 can be held to 1e-8.
"""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ros_pose_stats import part_from_mesh, shapes
from ros_pose_stats.records.scene import GRAVITY
from ros_pose_stats.resting.convex_body import convex_body
from ros_pose_stats.simulation.record_drop import record_drop

from ..bodies import oblique_prism, random_polyhedron
from ..reference.drop_solver import Body, reference_drop, released
from ..volume import few_quick

EVENTS = 5
AGREED = 1e-8
SAME_TIME = 1e-10  # contact forces that come down to zero together


def lighter_rim(surface, share):
    """The same solid with a smaller moment of inertia: it pulls away from the plate."""
    inertia = part_from_mesh(*surface).inertia
    return part_from_mesh(*surface, mass=1.0, inertia=share * inertia)


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
        "shifted": part_from_mesh(*shapes.box(1.0, 2.0, 3.0), center_of_mass=(0.1, -0.6, 1.2)),
        **{f"light {seed}": lighter_rim(random_polyhedron(6 + seed % 5, seed), 0.3)
           for seed in (0, 10, 23)},
    }


CASES = [  # body, restitution, height in radii (0.01: released touching), seed of the start
    ("random 5", 0.0, 2.0, 1), ("random 5", 0.8, 20.0, 2), ("random 10", 0.5, 20.0, 3),
    ("random 10", 0.2, 2.0, 4), ("random 30", 0.8, 2.0, 5), ("random 30", 0.0, 20.0, 6),
    ("tetrahedron", 0.5, 2.0, 7), ("tetrahedron", 0.0, 0.01, 8), ("box", 0.5, 20.0, 9),
    ("box", 0.0, 2.0, 10), ("prism", 0.8, 20.0, 11), ("prism", 0.2, 2.0, 12),
    ("prism", 0.2, 0.01, 13), ("leaning prism", 0.5, 20.0, 14), ("needle", 0.5, 2.0, 15),
    ("needle", 0.2, 20.0, 16), ("plate", 0.5, 20.0, 17), ("plate", 0.0, 2.0, 18),
    ("shifted", 0.8, 2.0, 19), ("shifted", 0.0, 0.01, 20), ("random 10", 0.5, 0.01, 21),
    ("random 10", 0.01, 2.0, 22), ("light 10", 0.0, 1.5, 10), ("light 23", 0.0, 1.5, 23),
    ("light 0", 0.0, 1.5, 0),
]
QUICK = CASES[::4]


def direction(seed):
    down = np.random.default_rng(seed).standard_normal(3)
    return down / np.linalg.norm(down)


@cache
def both(name, restitution, height, seed):
    """Points and radius of a body, its trajectory and what the other solver found."""
    part = bodies()[name]
    points = part.surface_vertices - part.center_of_mass
    radius = np.linalg.norm(points, axis=1).max()
    points = points / radius
    inertia = part.inertia / (part.mass * radius**2)
    start = direction(seed)
    found = record_drop(part, start=start, restitution=restitution, to_rest=True,
                        drop_height=height * radius)
    begin = released(Body(points, inertia), start, height)[2:11].reshape(3, 3)
    expected = reference_drop(points, inertia, start, restitution, height, EVENTS)
    return points, radius, found, begin, expected


def whole_events(found):
    """First and last row of every event between release and end.

    An arrival goes with its impacts and the stop; lift-offs go with others at the same time.
    """
    unit = np.sqrt(found.radius / GRAVITY)
    whole = []
    for event in found.events:
        before = whole[-1][-1] if whole else event
        together = (event.kind == before.kind == "lift-off"
                    and event.time - before.time < SAME_TIME * unit)
        if event.kind in ("impact", "stop") or together:
            whole[-1].append(event)
        else:
            whole.append([event])
    return [(rows[0], rows[-1]) for rows in whole[1:-1]]


def numbers(event, radius, unit):
    """Time and state (9,) in radii and sqrt(radius / g)."""
    return np.concatenate(((event.time / unit, event.height / radius,
                            event.velocity * unit / radius), event.up,
                           event.angular_velocity * unit))


@pytest.mark.parametrize(
    "case", few_quick([*QUICK, *(one for one in CASES if one not in QUICK)], len(QUICK)),
    ids=lambda case: "-".join(map(str, case)))
def test_same_first_events(case):
    """Kinds, times, states and vertices, and the orientations.

    The turn about the vertical at release is arbitrary, what follows is not.
    """
    points, radius, found, begin, expected = both(*case)
    unit = np.sqrt(radius / GRAVITY)
    events = whole_events(found)[:EVENTS]
    assert len(events) == len(expected) > 0
    kinds = {"arrival": "impact", "lift-off": "release"}
    assert [kinds[first.kind] for first, _ in events] == [event.kind for event in expected]
    ours = np.array([numbers(last, radius, unit) for _, last in events])
    theirs = np.array([numbers(event, 1.0, 1.0) for event in expected])
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=AGREED)

    hull = convex_body(bodies()[case[0]], 0).points
    np.testing.assert_allclose([hull[first.vertex] for first, _ in events],
                               points[[event.vertex for event in expected]], rtol=0, atol=1e-12)

    turned = Rotation.from_quat(found.orientations).as_matrix()
    yaw = begin @ turned[0].T
    assert yaw[2] == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)
    for (_, last), event in zip(events, expected, strict=True):
        here = np.flatnonzero(found.times == last.time)[-1]
        np.testing.assert_allclose(yaw @ turned[here], event.rotation, rtol=0, atol=AGREED)


@pytest.mark.long
def test_cases_show_everything():
    """Contacts of each mode, lift-offs and ends of infinite series are among the events."""
    seen = set()
    for case in CASES:
        found = both(*case)[2]
        for first, last in whole_events(found)[:EVENTS]:
            seen |= {first.kind, last.kind, last.mode}
    assert {"impact", "stop", "lift-off", "flight", "vertex", "edge"} <= seen
