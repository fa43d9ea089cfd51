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

"""Gears whose tips are rounded, as CAD programs export them; axis z, in millimetres.

Several corners lie side by side on each tip, and none of them is quite on a circle.
"""

import numpy as np
from manifold3d import CrossSection, JoinType, Manifold

from .fine_parts import surface

TIP = 10.0
ROOT = 8.2
WIDTH = 9.0
FILLET = 0.1
STEPS = 4
"""Of the gear: radii, width of its teeth, radius of all outer edges, and how many edges
stand for a quarter of a turn of these."""


def outline(teeth, missing=()):
    """Teeth with straight flanks of which tips take a third; some may be missing."""
    pitch = 2.0 * np.pi / teeth
    corners = []
    for number in range(teeth):
        angles = pitch * (number + np.array([-0.35, -0.165, 0.165, 0.35]))
        radii = [ROOT, TIP, TIP, ROOT] if number not in missing else [ROOT] * 4
        corners += zip(radii * np.cos(angles), radii * np.sin(angles), strict=True)
    return CrossSection([corners])


def toothed_disc(teeth, width=WIDTH, missing=()):
    """Teeth from z = 0 to `width`, all outer edges rounded."""
    section = outline(teeth, missing)
    section = section.offset(-FILLET, JoinType.Round, 2.0, 4 * STEPS)
    disc = Manifold()
    for angle in np.radians(np.linspace(0.0, 90.0, STEPS + 1)):
        inset = FILLET * (1.0 - np.cos(angle))
        level = section.offset(FILLET - inset, JoinType.Round, 2.0, 4 * STEPS)
        low = FILLET * (1.0 - np.sin(angle))
        disc += Manifold.extrude(level, width - 2.0 * low).translate((0.0, 0.0, low))
    return disc


def hub(height, radius=6.0):
    """A round boss from z = 0 on."""
    return Manifold.cylinder(height, radius, radius, 96)


def gear(teeth, boss=6.0, keyway=0.0, missing=()):
    """A gear with a bore, a boss above it and a keyway so wide along both."""
    solid = toothed_disc(teeth, missing=missing) + hub(WIDTH + boss)
    solid -= hub(3.0 * WIDTH, 3.0).translate((0.0, 0.0, -WIDTH))
    if keyway:
        slot = Manifold.cube((4.0, keyway, 6.0 * WIDTH), True)
        solid -= slot.translate((2.0, 0.0, 0.0))
    return surface(solid)


def double_gear(teeth, other_teeth, share):
    """Two gears of different pitch on one shaft, the upper one smaller."""
    upper = toothed_disc(other_teeth).scale((share, share, 1.0))
    shaft = hub(2.6 * WIDTH, 3.0)
    return surface(
        toothed_disc(teeth) + upper.translate((0.0, 0.0, 1.3 * WIDTH)) + shaft
    )
