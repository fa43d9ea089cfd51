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

"""Parts as CAD programs export them: circles as polygons of any number of sides, in
float32.

A surface is a pair of vertices (V, 3) and outward triangles (T, 3).
"""

import numpy as np

from . import shapes
from .variants import joined


def circle(sides, start=0.0):
    """Angles of a full turn."""
    return start + 2.0 * np.pi * np.arange(sides) / sides


def turned(profile, angles):
    """Solid of revolution of a closed profile of (r, z), counter-clockwise, about z.

    Where two neighbouring points of the profile lie on the axis nothing joins them.
    """
    points = [
        np.column_stack(
            (r * np.cos(angles), r * np.sin(angles), np.full(len(angles), z))
        )
        for r, z in profile
    ]
    n = len(angles)
    m = len(profile)
    corner = np.arange(n)
    next_corner = (corner + 1) % n
    triangles = []
    for k, (r, _) in enumerate(profile):
        j = (k + 1) % m
        if r > 0.0:
            triangles.append(
                np.column_stack(
                    (k * n + corner, k * n + next_corner, j * n + next_corner)
                )
            )
        if profile[j][0] > 0.0:
            triangles.append(
                np.column_stack((k * n + corner, j * n + next_corner, j * n + corner))
            )
    return np.vstack(points), np.vstack(triangles)


def extruded(outline, length, chamfer=0.0):
    """Prism over a star-shaped outline (n, 2), counter-clockwise, along z."""
    middle = outline.mean(axis=0) if not chamfer else (0.0, 0.0)
    levels = [(1.0, 0.0), (1.0, length)]
    if chamfer:
        levels = [
            (1.0 - chamfer, 0.0),
            (1.0, chamfer),
            (1.0, length - chamfer),
            (1.0 - chamfer, length),
        ]
    rings = [np.insert(outline * scale, 2, level, axis=1) for scale, level in levels]
    return shapes.lofted(np.array(rings), [(*middle, 0.0), (*middle, length)])


def cylinder(sides, height, start=0.0):
    """Diameter 1."""
    return turned(
        [(0.0, 0.0), (0.5, 0.0), (0.5, height), (0.0, height)], circle(sides, start)
    )


def tube(sides, start=0.0):
    """A ring with a bore of half its diameter."""
    return turned(
        [(0.5, 0.0), (1.0, 0.0), (1.0, 0.5), (0.5, 0.5)], circle(sides, start)
    )


def eccentric_tube(sides):
    """A tube with its bore aside, so that its centre of mass is beside its axis."""
    vertices, triangles = tube(sides)
    is_bore = np.hypot(vertices[:, 0], vertices[:, 1]) < 0.75
    return vertices + np.outer(is_bore, (0.3, 0.0, 0.0)), triangles


def ring(sides, start=0.0):
    """A bearing: chamfered outside, with a bore."""
    return turned(
        [(0.5, 0.0), (0.96, 0.0), (1.0, 0.04), (1.0, 0.56), (0.96, 0.6), (0.5, 0.6)],
        circle(sides, start),
    )


def shaft(sides, start=0.0):
    """Three steps."""
    return turned(
        [
            (0.0, 0.0),
            (0.3, 0.0),
            (0.3, 0.5),
            (0.5, 0.5),
            (0.5, 1.4),
            (0.2, 1.4),
            (0.2, 2.0),
            (0.0, 2.0),
        ],
        circle(sides, start),
    )


def frustum(sides, start=0.0):
    """A cone without its tip."""
    return turned(
        [(0.0, 0.0), (0.5, 0.0), (0.3, 0.6), (0.0, 0.6)], circle(sides, start)
    )


def screw(sides, start=0.0):
    """Hexagon head on a round shank."""
    head = extruded(0.5 * np.column_stack((np.cos(circle(6)), np.sin(circle(6)))), 0.3)
    shank = turned(
        [(0.0, 0.3), (0.25, 0.3), (0.25, 1.5), (0.0, 1.5)], circle(sides, start)
    )
    return joined(head, shank)


def d_shaft(sides, start=0.0):
    """Round but for a flat that takes 60 degrees; the arc begins and ends at the
    flat.
    """
    angles = np.radians(
        30.0 + 300.0 * np.arange(round(sides * 5 / 6) + 1) / round(sides * 5 / 6)
    )
    outline = np.column_stack((np.cos(angles), np.sin(angles)))
    turn = np.array([[np.cos(start), np.sin(start)], [-np.sin(start), np.cos(start)]])
    return extruded(outline @ turn, 0.8)


def capsule(sides, length=1.0):
    """Two half balls of radius 1/2 on a cylinder, divided alike along and around."""
    steps = np.radians(np.linspace(-90.0, 0.0, sides // 4 + 1))
    lower = [(0.5 * np.cos(a), 0.5 * np.sin(a)) for a in steps]
    lower[0] = (0.0, -0.5)
    upper = [(r, length - z) for r, z in lower[::-1]]
    return turned(lower + upper, circle(sides))


def filleted_box(sides, fillet=0.15):
    """Box 1 : 0.8 : 0.6 whose edges are rounded; `sides` is a multiple of 4."""
    steps = np.radians(np.linspace(0.0, 90.0, sides // 4 + 1))
    octant = np.array(
        [
            (np.cos(a) * np.cos(b), np.cos(a) * np.sin(b), np.sin(a))
            for a in steps
            for b in (steps if a < steps[-1] else steps[:1])
        ]
    )
    half = np.array((0.5, 0.4, 0.3)) - fillet
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return shapes.hull_mesh(
        np.vstack([sign * (half + fillet * octant) for sign in signs])
    )


def gear(teeth, tip=0.5, length=0.4, chamfer=0.0):
    """Teeth of which each tip takes this share of its pitch; pointed ones take none."""
    outline = []
    for angle in circle(teeth):
        pitch = 2.0 * np.pi / teeth
        gap = 0.5 * (1.0 - max(tip, 0.0))
        corners = [
            (0.85, -0.5),
            (0.85, -gap),
            (1.0, -0.5 * tip),
            (1.0, 0.5 * tip),
            (0.85, gap),
        ]
        if tip == 0.0:
            corners = [(0.85, -0.5), (1.0, 0.0)]
        outline += [
            (r * np.cos(angle + s * pitch), r * np.sin(angle + s * pitch))
            for r, s in corners
        ]
    return extruded(np.array(outline), length, chamfer)


def notched_disc(sides, width=12.0, depth=0.2, length=0.5, start=0.0):
    """A disc with one notch of so many degrees."""
    half = np.radians(0.5 * width)
    arc = (
        np.linspace(half, 2.0 * np.pi - half, round(sides * (1.0 - width / 360.0)) + 1)
        + start
    )
    outline = np.column_stack((np.cos(arc), np.sin(arc)))
    inner = (1.0 - depth) * np.array(
        [
            (np.cos(start - half), np.sin(start - half)),
            (np.cos(start + half), np.sin(start + half)),
        ]
    )
    return extruded(np.vstack((outline, inner)), length)


def ellipse(sides, ratio=0.6, length=0.5):
    """An elliptic disc."""
    angles = circle(sides, 0.1)
    return extruded(np.column_stack((np.cos(angles), ratio * np.sin(angles))), length)


def slot(sides, straight=1.0, length=0.4):
    """Two half discs of radius 1/2 and what lies between."""
    half = np.linspace(-0.5 * np.pi, 0.5 * np.pi, sides // 2 + 1)
    right = np.column_stack((0.5 * straight + 0.5 * np.cos(half), 0.5 * np.sin(half)))
    return extruded(np.vstack((right, -right)), length)
