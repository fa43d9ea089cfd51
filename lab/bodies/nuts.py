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

"""Random nuts, bolt heads and cap nuts, whose corners are turned off, and springs.

The turned chamfer of a polygon is a cone that meets each of its sides in an arc. A part
that tilts over its end rocks on that arc. Lengths are in units of the part; only their
ratios matter.
"""

import math

import numpy as np
from numpy.random import Generator

from ros_pose_stats.core.shapes.profiles import unit_circle

from .shapes import lofted
from .solids import Solid
from .turned import _rings, _sides, disc

DEEPEST = 0.45
"""Share of the height that a chamfer takes at most."""


def nuts(draw: Generator) -> list[Solid]:
    """Squares, hexagons and octagons, chamfered at one end or both, most with a bore.

    Some have a washer face at one end.
    """
    sides = _sides(draw)
    height = math.exp(draw.uniform(math.log(0.3), math.log(3.0)))
    corners = int(draw.choice([4, 6, 6, 6, 8]))
    rim = float(draw.uniform(0.85, 1.03))
    chamfer = (rim, math.radians(draw.uniform(8.0, 50.0)))
    upper_only = draw.random() < 0.4
    solids = [
        chamfered(corners, sides, height, None if upper_only else chamfer, chamfer)
    ]
    top = height
    if draw.random() < 0.2:
        top += float(draw.uniform(0.02, 0.1))
        solids.append(disc(sides, min(rim, 0.99), height, top))
    if draw.random() < 0.75:
        solids.append(disc(sides, float(draw.uniform(0.3, 0.65)), 0.0, top).hole())
    return solids


def cap_nuts(draw: Generator) -> list[Solid]:
    """Chamfered squares to octagons under a dome, most with a blind bore."""
    sides = 4 * int(draw.integers(8, 25))
    height = math.exp(draw.uniform(math.log(0.3), math.log(1.5)))
    rim = float(draw.uniform(0.85, 1.0))
    chamfer = (rim, math.radians(draw.uniform(10.0, 45.0)))
    radius = rim * float(draw.uniform(0.75, 0.98))
    rise = radius * float(draw.uniform(0.5, 1.2))
    level = np.linspace(0.0, 1.0, sides // 4 + 1)
    dome = zip(
        (radius * np.sqrt(1.0 - level * level)).tolist(),
        (height + rise * level).tolist(),
        strict=True,
    )
    solids = [
        chamfered(int(draw.choice([4, 6, 6, 6, 8])), sides, height, chamfer, chamfer),
        _rings(sides, dome),
    ]
    if draw.random() < 0.75:
        bore = float(draw.uniform(0.3, 0.6))
        solids.append(disc(sides, bore, 0.0, height * draw.uniform(0.7, 1.0)).hole())
    return solids


def springs(draw: Generator) -> list[Solid]:
    """Coils of round wire with open or closed ends, some ground flat."""
    turns = draw.uniform(3.0, 12.0)
    wire = 1.0 / draw.uniform(2.5, 8.0)  # its radius over that of the coil
    pitch = 2.0 * wire * draw.uniform(1.1, 2.5)
    is_closed = draw.random() < 0.6
    turn = 2.0 * math.pi * np.arange(0.0, turns, 1.0 / int(draw.integers(24, 41)))
    # Closed ends lie next to the coil for a turn.
    slope = np.full(turn.shape, pitch / (2.0 * math.pi))
    if is_closed:
        slope[np.minimum(turn, turn[-1] - turn) < 2.0 * math.pi] = (
            1.02 * 2.0 * wire / (2.0 * math.pi)
        )
    level = np.concatenate(([0.0], np.cumsum(slope[:-1] * np.diff(turn))))
    section = wire * unit_circle(10)[::-1]  # as seen from the end of the coil
    outward = 1.0 + section[:, 0]
    rings = np.stack(
        (
            np.cos(turn)[:, None] * outward,
            np.sin(turn)[:, None] * outward,
            level[:, None] + section[:, 1],
        ),
        axis=2,
    )
    if is_closed and draw.random() < 0.6:
        cut = wire * float(draw.uniform(0.5, 1.0))
        rings[:, :, 2] = np.clip(rings[:, :, 2], cut - wire, level[-1] + wire - cut)
    corners, triangles = lofted(rings, rings[[0, -1]].mean(axis=1))
    return [Solid(corners, triangles=triangles)]


def chamfered(
    corners: int,
    sides: int,
    height: float,
    lower: tuple[float, float] | None,
    upper: tuple[float, float] | None,
) -> Solid:
    """A regular prism about z, whose inner radius is 1, chamfered at its ends.

    A chamfer is the radius of the circle that it leaves at the end and the angle by
    which its cone falls from there, radians. Deep ones are cut less steeply.
    """
    step = 2.0 * math.pi / corners
    turn = 2.0 * math.pi * np.arange(sides) / sides
    turn = np.union1d(turn, step * np.arange(corners))
    turn = turn[np.append(np.diff(turn) > 1e-9, True)]
    reach = 1.0 / np.cos(turn % step - 0.5 * step)
    toward = np.column_stack((np.cos(turn), np.sin(turn)))
    rings = []
    for level, inward, chamfer in ((0.0, 1.0, lower), (height, -1.0, upper)):
        rim, angle = chamfer or (math.inf, 0.0)
        beyond = np.maximum(reach - rim, 0.0)
        slope = math.tan(angle)
        if beyond.max() * slope > DEEPEST * height:
            slope = DEEPEST * height / float(beyond.max())
        for radius, depth in (
            (np.minimum(reach, rim), np.zeros(len(turn))),
            (reach, slope * beyond),
        ):
            rings.append(
                np.column_stack((toward * radius[:, None], level + inward * depth))
            )
    return Solid(np.unique(np.vstack(rings), axis=0))
