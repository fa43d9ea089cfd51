"""Corners that may land during a step: none that does is left out, however many there are."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, shapes
from ros_pose_stats.kernels.drops.candidates import candidates, height_series
from ros_pose_stats.kernels.drops.free_motion import free_series, shorten
from ros_pose_stats.kernels.drops.layout import (
    COLUMNS,
    ORDER,
    PS,
    ZS,
    DropRules,
    P,
    V,
    W,
    Z,
    new_work,
)
from ros_pose_stats.simulation.drop_body import drop_body
from ros_pose_stats.simulation.record_drop import record_drop
from ros_pose_stats.tolerances import SLOW, SOFT, TOUCHING, TRUNCATION

from .motions import turning

MARGINS = (TOUCHING, 1e-3)


@cache
def part_of(name):
    """Bodies of 5 000 corners: round, flat, and with most of them at one end."""
    points = np.random.default_rng(16).standard_normal((5000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    shape = {"round": (1.0, 1.0, 1.0), "flat": (1.0, 0.8, 0.05), "long": (1.0, 0.1, 0.1),
             "few": (1.0, 0.7, 0.5)}[name]
    return part_from_mesh(*shapes.hull_mesh((points[:12] if name == "few" else points) * shape))


def rules(margin):
    return DropRules(0.5, 20.0, False, TRUNCATION, margin, SLOW, SOFT, 1000)


def steps(body, count, seed):
    """Series of flights near the plate, some fast and some slow, and their last rows."""
    random = np.random.default_rng(seed)
    points = np.column_stack((body.x, body.y, body.z))
    for k in range(count):
        speed = 10.0 ** random.uniform(-3.0, 1.0)
        state = turning(body.moment, random.standard_normal(3), speed, 100 * seed + k)
        state[Z] = -(points @ state[P:P + 3]).min() + 10.0 ** random.uniform(-9.0, -0.5)
        state[V] = random.uniform(-2.0, 1.0)
        step = random.uniform(0.01, 1.0) / np.linalg.norm(state[W:])
        series = np.zeros((ORDER + 1, COLUMNS))
        last = free_series(state, body.moment, min(step, 0.5), TRUNCATION, series)
        shorten(series, last, TRUNCATION)
        yield series, last, points


def heights_at(series, last, points, fraction):
    """Heights (C,) at a fraction of the step."""
    at = fraction ** np.arange(last + 1) @ series[:last + 1]
    return at[ZS] + points @ at[PS:PS + 3]


def landing(series, last, points, margin):
    """Corners that come within the margin before the first one sinks below the plate."""
    low, high = 0.0, 1.0
    near = set()
    for fraction in np.linspace(0.0, 1.0, 41):
        heights = heights_at(series, last, points, fraction)
        if heights.min() < 0.0:
            high = fraction
            break
        low = fraction
        near.update(np.flatnonzero(heights <= margin).tolist())
    while high - low > 1e-14:
        middle = 0.5 * (low + high)
        if heights_at(series, last, points, middle).min() < 0.0:
            high = middle
        else:
            low = middle
    return near | set(np.flatnonzero(heights_at(series, last, points, low) <= margin).tolist())


@pytest.mark.long
@pytest.mark.parametrize("name", ["round", "flat", "long", "few"])
@pytest.mark.parametrize("margin", MARGINS)
def test_none_is_missed(name, margin):
    body = drop_body(part_of(name), 0.005, 0).arrays
    work = new_work(body.x.shape[0])
    listed = landed = 0
    for series, last, points in steps(body, 60, 17):
        work.series[:] = series
        count = candidates(body, rules(margin), work, last)
        found = work.found[:count]
        assert len(set(found.tolist())) == count
        lands = landing(series, last, points, margin - 1e-14)
        assert lands <= set(found.tolist())
        listed, landed = listed + count, landed + len(lands)
    # Far fewer than all are looked at, else the search would be of no use.
    assert 20 < landed <= listed < (0.35 * 60 * len(points) if name != "few" else 60 * 12 + 1)


def test_height_series():
    body = drop_body(part_of("few"), 0.005, 0).arrays
    c = np.zeros(ORDER + 1)
    for series, last, points in steps(body, 5, 18):
        for j, point in enumerate(points):
            height_series(body, series, last, j, c)
            expected = series[:last + 1, ZS] + series[:last + 1, PS:PS + 3] @ point
            np.testing.assert_allclose(c[:last + 1], expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", ["round", "flat", "long"])
def test_drops_of_many_corners_stay_above_the_plate(name):
    """All corners, at many instants of drops at both ends of the restitutions."""
    part = part_of(name)
    corners = part.vertices - part.center_of_mass
    for k, restitution in enumerate((0.0, 0.7)):
        found = record_drop(part, k, restitution, seed=19, round_sides=0)
        chosen = np.linspace(0, len(found.times) - 1, 300).astype(int)
        lowest = (found.heights[chosen] + corners @ found.up[chosen].T).min()
        assert lowest > -2.0 * TOUCHING * found.radius
