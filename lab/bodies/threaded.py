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

"""Bolts, nuts and springs that wind, as CAD programs export them.

Along a thread the corners of its profile lie on helices, `sides` to a turn. Lengths are
in millimetres, those of ISO 4014 and 4032 for M8 with a rounded depth of the thread.
"""

import numpy as np
from manifold3d import CrossSection, Manifold

from ros_pose_stats.core.shapes.profiles import unit_circle

from .fine_parts import surface
from .shapes import lofted

PITCH = 1.25
CREST = 4.0
CORE = 3.3
ACROSS_FLATS = 13.0
CHAMFER = 30.0  # degrees, of both ends of a nut and of the head


def thread(turns, sides, start=0.0, hand=1, crest=CREST, core=CORE):
    """A threaded rod along z, from 0 on; `start`: angle of the profile, degrees."""
    angles = np.arange(sides) / sides
    # Crest and root take an eighth and a quarter of the pitch, the flanks the rest.
    flank = np.clip((np.abs(2.0 * angles - 1.0) - 0.125) / 0.625, 0.0, 1.0)
    radius = crest - (crest - core) * flank
    outline = radius[:, None] * unit_circle(sides)
    length = turns * PITCH
    steps = max(round(turns * sides), 1)
    rod = Manifold.extrude(CrossSection([outline]), length, steps, hand * 360.0 * turns)
    return rod.rotate((0.0, 0.0, start))


def hexagon(height, both_ends=True, turn=0.0):
    """A hexagonal prism from z = 0 on, its upper or both ends chamfered."""
    corner = ACROSS_FLATS / np.sqrt(3.0)
    prism = Manifold.extrude(CrossSection([corner * unit_circle(6)]), height)
    rise = np.tan(np.radians(CHAMFER))
    middle = 0.5 * ACROSS_FLATS
    wide = middle + (height / rise if rise else 0.0)
    cone = Manifold.cylinder(height, wide, middle, 96)
    prism ^= cone
    if both_ends:
        prism ^= cone.mirror((0.0, 0.0, 1.0)).translate((0.0, 0.0, height))
    return prism.rotate((0.0, 0.0, turn))


def bolt(sides, turns=18.0, start=0.0, hand=1, turn=0.0):
    """A bolt threaded all along, its tip chamfered; the head is below z = 0."""
    length = turns * PITCH
    tip = Manifold.cylinder(length, CREST + length - 0.9, CREST - 0.9, 96)
    shank = thread(turns, sides, start, hand) ^ tip
    head = hexagon(5.3, False, turn).mirror((0.0, 0.0, 1.0))
    return surface(shank + head)


def nut(sides, start=0.0, hand=1, turn=0.0, height=6.5):
    """A nut, threaded through, with countersunk ends."""
    tap = thread(height / PITCH + 2.0, sides, start, hand, CREST + 0.1, CORE + 0.1)
    wide = CREST + 0.4
    sink = Manifold.cylinder(wide, wide, 0.0, 96)
    solid = hexagon(height, True, turn) - tap.translate((0.0, 0.0, -PITCH))
    solid -= sink
    return surface(solid - sink.mirror((0.0, 0.0, 1.0)).translate((0.0, 0.0, height)))


def cap_screw(sides, turns=18.0, start=0.0, hand=1):
    """The same shank with a round head."""
    head = Manifold.cylinder(8.0, 6.5, 6.5, 96).translate((0.0, 0.0, -8.0))
    return surface(thread(turns, sides, start, hand) + head)


def spring(sides, turns=8.0, pitch=2.2, radius=10.0, wire=1.0):
    """A compression spring with plain ends, its wire round."""
    angle = 2.0 * np.pi * np.arange(round(turns * sides) + 1) / sides
    rise = pitch / (2.0 * np.pi)
    outward = np.column_stack((np.cos(angle), np.sin(angle), 0.0 * angle))
    along = np.column_stack(
        (-radius * np.sin(angle), radius * np.cos(angle), np.full(len(angle), rise))
    )
    across = np.cross(outward, along / np.hypot(radius, rise))
    middle = radius * outward + np.outer(rise * angle, (0.0, 0.0, 1.0))
    section = wire * unit_circle(16)
    rings = (
        middle[:, None]
        + section[:, :1] * outward[:, None]
        - section[:, 1:] * across[:, None]
    )
    return lofted(rings, middle[[0, -1]])
