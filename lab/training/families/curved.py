"""More parts that rock: arcs that end in corners, cut cones, capsules, pillows and slices."""

import math

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from ros_pose_stats.core.shapes.profiles import unit_circle

from .rocking import _arc, _drawn
from .solids import Solid
from .turned import _cut, _rings

Array = NDArray[np.float64]


def flatted_shafts(draw: Generator) -> list[Solid]:
    """Shafts with two or three flats, opposite, square to each other or anywhere."""
    turn = np.array([[0.0, math.pi], [0.0, 0.5 * math.pi], [0.0, 2.0], [0.0, 2.6]])[
        int(draw.integers(4))
    ]
    if draw.random() < 0.3:
        turn = np.append(turn, turn[-1] + draw.uniform(1.2, 2.2))
    far = (
        draw.uniform(0.5, 0.95, turn.size)
        if draw.random() < 0.5
        else np.full(turn.size, draw.uniform(0.5, 0.95))
    )
    return _drawn(
        _cut_outline(
            _arc(draw, 0.0, 2.0 * math.pi)[:-1],
            np.column_stack((np.cos(turn), np.sin(turn))),
            far,
        ),
        draw,
    )


def lenses(draw: Generator) -> list[Solid]:
    """Outlines of two arcs that meet in corners, alike or not."""
    arcs = []
    for side in (1.0, -1.0):
        half = draw.uniform(0.3, 1.4)
        arc = _arc(draw, 0.5 * math.pi - half, 0.5 * math.pi + half) / math.sin(half)
        arcs.append((arc - (0.0, arc[0, 1])) * side)
    return _drawn(np.vstack(arcs), draw)


def loaves(draw: Generator) -> list[Solid]:
    """Blocks with an arched top, as wide as the arc or with shoulders."""
    half = draw.uniform(0.4, 1.5)
    arc = _arc(draw, 0.5 * math.pi - half, 0.5 * math.pi + half) / math.sin(half)
    arc = arc - (0.0, arc[0, 1] - draw.uniform(0.1, 2.0))
    foot = draw.uniform(0.6, 1.4) if draw.random() < 0.4 else 1.0
    return _drawn(np.vstack((arc, [(foot, 0.0), (-foot, 0.0)])), draw)


def cams(draw: Generator) -> list[Solid]:
    """Hulls of two circles of different size, some with a flat."""
    first = _arc(draw, 0.0, 2.0 * math.pi)[:-1]
    away = (draw.uniform(0.3, 1.8), 0.0)
    outline = np.vstack(
        (first, draw.uniform(0.2, 0.95) * _arc(draw, 0.0, 2.0 * math.pi)[:-1] + away)
    )
    if draw.random() < 0.4:
        outline[:, 1] = np.maximum(
            outline[:, 1], draw.uniform(0.5, 0.95) * outline[:, 1].min()
        )
    return _drawn(outline, draw)


def squircles(draw: Generator) -> list[Solid]:
    """Prisms of superellipses; some are cut at one side."""
    round_ = _arc(draw, 0.0, 2.0 * math.pi)[:-1]
    power = draw.uniform(1.5, 6.0)
    outline = round_ / (np.abs(round_) ** power).sum(axis=1, keepdims=True) ** (
        1.0 / power
    )
    if draw.random() < 0.4:
        outline[:, 0] = np.minimum(outline[:, 0], draw.uniform(0.3, 0.9))
    return _drawn(outline * (1.0, draw.uniform(0.5, 1.0)), draw)


def cut_cones(draw: Generator) -> list[Solid]:
    """Cones and barrels with one or two flats along them."""
    segments = 4 * int(draw.integers(12, 25))
    high = draw.uniform(0.4, 3.0)
    bulge = draw.uniform(0.0, 0.3) if draw.random() < 0.5 else 0.0
    level = np.linspace(0.0, 1.0, 9 if bulge else 2)
    radius = (
        1.0
        + level * (draw.uniform(0.3, 1.0) - 1.0)
        + 4.0 * bulge * level * (1.0 - level)
    )
    body = _rings(
        segments, zip(radius.tolist(), (high * level).tolist(), strict=True)
    ).corners
    for turn in (0.0, draw.uniform(1.0, 3.2))[: int(draw.integers(1, 3))]:
        along = np.array((math.cos(turn), math.sin(turn), 0.0))
        beyond = body @ along - draw.uniform(0.1, 0.9) * float(radius.min())
        body = body - np.maximum(beyond, 0.0)[:, None] * along
    return [Solid(body)]


def capsules(draw: Generator) -> list[Solid]:
    """Cylinders with round ends, one or both, with up to two flats."""
    segments = 4 * int(draw.integers(10, 19))
    high = draw.uniform(0.0, 3.0)
    turn = np.linspace(0.0, 0.5 * math.pi, segments // 4 + 1)[1:]
    flat = draw.uniform(0.3, 1.0)
    rings = [(math.cos(t), high + flat * math.sin(t)) for t in turn.tolist()]
    rings += [(1.0, high), (1.0, 0.0)]
    if draw.random() < 0.5:
        rings += [(math.cos(t), -flat * math.sin(t)) for t in turn.tolist()]
    body = _rings(segments, rings).corners
    for along in draw.normal(size=(int(draw.integers(0, 3)), 3)) * (1.0, 1.0, 0.3):
        along /= np.linalg.norm(along)
        reach = body @ along
        far = float(draw.uniform(0.6, 0.95) * reach.max())
        body = body - np.maximum(reach - far, 0.0)[:, None] * along
    return [Solid(body)]


def pillows(draw: Generator) -> list[Solid]:
    """What a box and a ball about its middle have in common."""
    half = draw.uniform(0.45, 0.98, 3)
    segments = 4 * int(draw.integers(10, 16))
    level = np.cos(np.linspace(0.0, math.pi, segments // 2 + 1)).tolist()
    ball = _rings(
        segments, ((math.sqrt(max(1.0 - z * z, 0.0)), z) for z in level)
    ).corners
    axes = np.vstack((np.eye(3), -np.eye(3)))
    points = _cut(ball, axes, np.concatenate((half, half)), segments)
    if len(points) < 12:
        points = np.clip(ball, -half, half)
    return [Solid(points * (1.0, 1.0, draw.uniform(0.7, 1.3)))]


def slices(draw: Generator) -> list[Solid]:
    """Slices of a ball or a spheroid between two planes through its axis."""
    wide = math.radians(draw.uniform(40.0, 180.0))
    steps = int(draw.integers(12, 30))
    turn = np.linspace(0.0, wide, steps)
    level = np.linspace(-0.5 * math.pi, 0.5 * math.pi, steps)
    ball = np.array(
        [
            (math.cos(a) * math.cos(t), math.cos(a) * math.sin(t), math.sin(a))
            for a in level.tolist()
            for t in turn.tolist()
        ]
    )
    return [Solid(ball * (1.0, 1.0, draw.uniform(0.5, 1.8)))]


def half_rings(draw: Generator) -> list[Solid]:
    """Cylinders with a flat and a bore beside it: shells and clamps."""
    outline = _arc(draw, 0.0, 2.0 * math.pi)[:-1]
    outline[:, 1] = np.maximum(outline[:, 1], -draw.uniform(0.1, 0.9))
    (whole,) = _drawn(outline, draw, 0.2, 3.0)
    long = float(whole.corners[:, 2].max())
    size = draw.uniform(0.2, 0.6) * (1.0 + outline[:, 1].min() * -1.0) * 0.5
    middle = 0.5 * (1.0 + outline[:, 1].min())
    hole = np.column_stack((unit_circle(48) * size + (0.0, middle), np.zeros(48)))
    return [whole, Solid(np.vstack((hole, hole + np.array((0.0, 0.0, long)))), -1.0)]


def _cut_outline(outline: Array, normals: Array, far: Array) -> Array:
    """An outline with what lies beyond lines moved onto them."""
    for normal, away in zip(normals, far.tolist(), strict=True):
        outline = outline - np.maximum(outline @ normal - away, 0.0)[:, None] * normal
    return outline


CURVED = {
    "flatted shafts": flatted_shafts,
    "lenses": lenses,
    "loaves": loaves,
    "cams": cams,
    "squircles": squircles,
    "cut cones": cut_cones,
    "capsules": capsules,
    "pillows": pillows,
    "slices": slices,
    "half rings": half_rings,
}
