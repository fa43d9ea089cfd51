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

"""The poses of common parts, as who writes a feeder's list by hand would write them.

The lists were written down before any was run. What decides is how far the centre of
mass has to rise out of a pose, over its height there: 0.0025 parts poses, 0.025
neighbours on one round or toothed run. A face h high whose nearest edge is w from the
foot rises by sqrt(1 + (w / h)^2) - 1, so that a part more than 14.1 times as high as
wide does not stand.
"""

import itertools

import numpy as np
import pytest
import trimesh
from manifold3d import CrossSection, Manifold

from lab.bodies import exports, shapes
from lab.bodies.fine_parts import surface
from ros_pose_stats import part_from_mesh, resting_poses
from ros_pose_stats.core.shapes import demo_parts


def bar_of(outline, length):
    """A profile along z."""
    return Manifold.extrude(CrossSection([np.array(outline)]), length)


def profile(outline, length):
    return surface(bar_of(outline, length))


def polygon(sides, radius):
    return radius * np.column_stack(
        (np.cos(exports.circle(sides)), np.sin(exports.circle(sides)))
    )


def nut():
    """M8: 13 across its flats, 6.5 high."""
    return bar_of(polygon(6, 13.0 / np.sqrt(3.0)), 6.5) - Manifold.cylinder(
        6.5, 3.4, circular_segments=36
    )


def turned(*outline, sides=48):
    return exports.turned(list(outline), exports.circle(sides, 0.1))


def coin(ratio, sides=64):
    return exports.cylinder(sides, ratio, 0.3)


def tube(outer, inner, length, sides=40):
    return turned(
        (inner, 0.0), (outer, 0.0), (outer, length), (inner, length), sides=sides
    )


def hexagon_bolt(length):
    """Hexagon head of radius 0.5 and height 0.3, shank of radius 0.25."""
    return surface(
        bar_of(polygon(6, 0.5), 0.3)
        + Manifold.cylinder(length, 0.25, circular_segments=48).translate(
            (0.0, 0.0, 0.3)
        )
    )


def signs():
    return np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


def box_without_edges(size, chamfer):
    """All twelve edges of a box off at 45 degrees."""
    inset = chamfer * np.vstack((1.0 - np.eye(3), np.full((1, 3), 0.5)))
    octant = 0.5 * np.array(size) - inset
    return shapes.hull_mesh((signs()[:, None] * octant).reshape(-1, 3))


def cube_without_corner(cut):
    others = 0.5 * signs()[:-1]
    return shapes.hull_mesh(np.vstack((others, 0.5 - cut * np.eye(3))))


def grooved_shaft(width, depth, length=2.0):
    """A shaft of radius 1 with a key's groove all along."""
    return surface(
        Manifold.cylinder(length, 1.0, circular_segments=64)
        - Manifold.cube((1.0, width, length)).translate(
            (1.0 - depth, -0.5 * width, 0.0)
        )
    )


def eccentric():
    """A disc of radius 1 with a bore aside of the middle."""
    return surface(
        Manifold.cylinder(0.8, 1.0, circular_segments=64)
        - Manifold.cylinder(0.8, 0.3, circular_segments=32).translate((0.4, 0.0, 0.0))
    )


def ellipse(sides):
    return exports.extruded(np.array((1.0, 0.6)) * polygon(sides, 1.0), 0.5)


def half_disc(sides):
    arc = np.linspace(-0.5 * np.pi, 0.5 * np.pi, sides // 2 + 1)
    return exports.extruded(np.column_stack((np.cos(arc), np.sin(arc))), 2.0)


def ball(subdivisions, axes=(1.0, 1.0, 1.0)):
    sphere = trimesh.creation.icosphere(subdivisions=subdivisions)
    return sphere.vertices * axes, sphere.faces


def torus():
    ring = trimesh.creation.torus(1.0, 0.25, major_sections=48, minor_sections=32)
    return ring.vertices, ring.faces


def truncated_octahedron():
    octant = np.array(list(itertools.permutations((0.0, 1.0, 2.0))))
    return shapes.hull_mesh(
        np.unique((signs()[:, None] * octant).reshape(-1, 3), axis=0)
    )


ANGLE = [(0, 0), (1, 0), (1, 0.2), (0.2, 0.2), (0.2, 1), (0, 1)]
TEE = [
    (-0.1, 0),
    (0.1, 0),
    (0.1, 0.8),
    (0.5, 0.8),
    (0.5, 1),
    (-0.5, 1),
    (-0.5, 0.8),
    (-0.1, 0.8),
]
CHANNEL = [(0, 0), (1, 0), (1, 1), (0.8, 1), (0.8, 0.2), (0.2, 0.2), (0.2, 1), (0, 1)]

# Body, and the sizes of the groups of poses that turns of the part carry into each
# other.
LISTS = {
    # Bars and plates: on its end a bar 1 : 1 : t rises by sqrt(1 + t^-2) - 1.
    "cube": (shapes.box(1, 1, 1), (6,)),
    "brick": (shapes.box(1, 2, 3), (2, 2, 2)),
    "bar 1:1:6": (shapes.box(1, 1, 6), (2, 4)),
    "bar 1:1:14, rise 0.00255": (shapes.box(1, 1, 14), (2, 4)),
    "bar 1:1:20, rise 0.0012": (shapes.box(1, 1, 20), (4,)),
    "bar 1:2:60": (shapes.box(1, 2, 60), (2, 2)),
    "plate 1:10:20, on its short side 0.0012": (shapes.box(1, 10, 20), (2, 2)),
    "angle": (profile(ANGLE, 2.0), (1, 2, 2)),  # on its two tips too
    "tee": (profile(TEE, 2.0), (1, 1, 2, 2)),
    "channel": (profile(CHANNEL, 2.0), (1, 1, 2, 2)),
    # Edges and corners off.
    "cube, bevels that rise by 0.0014": (box_without_edges((1, 1, 1), 0.05), (6,)),
    "cube, bevels that rise by 0.031": (box_without_edges((1, 1, 1), 0.2), (6, 12)),
    "cube, corner off, rise 0.016": (cube_without_corner(0.3), (1, 3, 3)),
    "cube, corner off, rise 0.0013": (cube_without_corner(0.1), (3, 3)),
    "box, fillets of 16": (exports.filleted_box(16), (2, 2, 2)),
    "box, wide fillets": (exports.filleted_box(32, 0.25), (2, 2, 2)),
    # Regular and other solids.
    "icosahedron": (shapes.icosahedron(), (20,)),
    "truncated octahedron": (truncated_octahedron(), (6, 8)),
    "pyramid": (exports.turned([(0, 0), (1, 0), (0, 1.4)], exports.circle(4)), (1, 4)),
    "triangular plate, rise 0.0037": (shapes.prism(3, 1 / np.sqrt(3.0), 0.05), (2, 3)),
    "triangular plate, rise 0.0006": (shapes.prism(3, 1 / np.sqrt(3.0), 0.02), (2,)),
    "hexagon bar, twenty times": (shapes.prism(6, 1.0, 20 * np.sqrt(3.0)), (6,)),
    # From fifteen sides on a prism is round.
    "14-gon": (shapes.prism(14, 1.0, 1.5), (2, 14)),
    "15-gon": (shapes.prism(15, 1.0, 1.5), (1, 2)),
    # Discs and rods: on its rim a coin rises by sqrt(1 + (h / d)^2) - 1.
    "coin h/d 0.05, rise 0.0012": (coin(0.05), (2,)),
    "coin h/d 0.08, rise 0.0032": (coin(0.08), (1, 2)),
    "coin h/d 0.577": (coin(0.577), (1, 2)),
    "rod h/d 10, rise 0.005": (coin(10.0), (1, 2)),
    "rod h/d 20, rise 0.0012": (coin(20.0), (1,)),
    "washer": (tube(8.0, 4.2, 1.6), (1, 2)),
    "pipe": (tube(0.5, 0.45, 3.0), (1, 2)),
    "eccentric": (eccentric(), (1, 2)),
    "torus": (torus(), (2,)),
    # Turned parts that taper.
    "cone": (turned((0.0, 0.0), (0.5, 0.0), (0.0, 1.0)), (1, 1)),
    "stepped shaft": (exports.shaft(40), (1, 1, 1)),
    "flanged bush": (
        turned(
            (0.25, 0.0), (0.5, 0.0), (0.5, 0.1), (0.35, 0.1), (0.35, 0.8), (0.25, 0.8)
        ),
        (1, 1, 1),
    ),
    # Screws: on the tip, on the head, and on the rim of the head or six sides of it.
    "cap screw": (
        turned((0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.3, 0.5), (0.3, 2.0), (0.0, 2.0)),
        (1, 1, 1),
    ),
    "countersunk screw": (
        turned((0.0, 0.0), (0.5, 0.0), (0.25, 0.25), (0.25, 1.5), (0.0, 1.5)),
        (1, 1, 1),
    ),
    "nail, tip 0.0013": (
        turned(
            (0.0, 0.0), (0.5, 0.0), (0.5, 0.1), (0.15, 0.1), (0.15, 5.1), (0.0, 5.1)
        ),
        (1, 1),
    ),
    "hexagon bolt": (exports.screw(48), (1, 1, 6)),
    "bolt M8 x 30": (demo_parts.hex_bolt(), (1, 1, 6)),
    "demo clamp": (demo_parts.DEMO_PARTS["clamp"](), (1,) * 7),
    "demo bracket": (demo_parts.DEMO_PARTS["bracket"](), (1,) * 5),
    "demo gear, hub on one side": (demo_parts.DEMO_PARTS["gear"](), (1,) * 4),
    "long bolt, tip 0.0016": (hexagon_bolt(8.0), (1, 6)),
    "nut": (surface(nut()), (2, 6)),
    # Round but for something.
    "D-shaft": (exports.d_shaft(48), (1, 1, 2)),
    "half disc": (half_disc(32), (1, 1, 2)),
    "shaft with a keyway, on its edges 0.043": (grooved_shaft(0.6, 0.36), (1, 1, 2)),
    "disc with a notch of 12 degrees": (exports.notched_disc(60), (1, 2)),
    # Other curves.
    "capsule": (exports.capsule(64), (1,)),
    "ball": (ball(3), (1,)),
    "egg": (ball(4, (3.0, 2.0, 1.5)), (2,)),
    "ellipse of 64": (ellipse(64), (2, 2)),
    "slot": (exports.slot(64), (2, 2)),
    # Gears: two faces and a rim.
    **{
        f"gear, {teeth} teeth, {words}": (exports.gear(teeth, tip), (1, 2))
        for teeth in (15, 60)
        for tip, words in ((0.0, "pointed"), (0.5, "trapezoid"))
    },
    **{
        f"gear, {teeth} winding teeth": (
            surface(
                Manifold.extrude(
                    CrossSection([exports.gear(teeth, 0.3)[0][: 5 * teeth, :2]]),
                    0.4,
                    16,
                    10.0,
                )
            ),
            (1, 2),
        )
        for teeth in (16, 40)
    },
    "gear, chamfered": (exports.gear(24, 0.5, chamfer=0.03), (1, 2)),
    "thin gear": (exports.gear(40, 0.0, length=0.1), (2,)),
    "star of 12, gaps of 30 degrees": (exports.gear(12, 0.0), (2, 12)),
    "star of 12, gaps of 25.5 degrees": (exports.gear(12, 0.15), (2, 12)),
}


@pytest.mark.parametrize(("surface", "groups"), LISTS.values(), ids=LISTS)
def test_poses_and_groups(surface, groups):
    poses = resting_poses(part_from_mesh(*surface)).poses
    sizes = np.unique([pose.group for pose in poses], return_counts=True)[1]
    assert tuple(np.sort(sizes).tolist()) == groups
