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

"""The project's own demo parts, made as a machinist would: profiles, extrusions, cuts.

Each function returns a closed outward surface, vertices (V, 3) in millimetres and
triangles (T, 3). Coordinates are float32 numbers, since STL stores nothing finer: a
written part reads back exactly. This module and those that model solids need
manifold3d, so they are imported only where such parts are made.
"""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
from manifold3d import CrossSection, Manifold

from ...base import errors, files
from ..mesh import arrays
from ..mesh.files import stl_bytes
from ..records import Array, Index
from . import profiles
from .profiles import Outline, Surface, rounded_polygon, spur_gear, unit_circle


def clamp() -> Surface:
    """Body of a C-clamp, 42 mm by 36 mm by 18 mm, without any symmetry.

    The upper jaw ends in a fork with a transverse screw hole, counterbored on one side;
    the lower jaw has a nose, a sloping underside and a mounting hole.
    """
    side = rounded_polygon(
        [
            (0.0, 0.0, 5.0),
            (30.0, 0.0, 3.0),
            (42.0, 5.0, 1.5),
            (42.0, 13.0, 1.5),
            (36.5, 13.0, 1.0),
            (36.5, 10.0, 1.0),
            (11.0, 10.0, 4.0),
            (11.0, 25.0, 4.0),
            (40.0, 25.0, 2.0),
            (40.0, 36.0, 5.0),
            (8.0, 36.0, 4.0),
            (0.0, 27.0, 4.0),
        ]
    )
    slot = rounded_polygon(
        [(4.0, 27.0, 2.9), (4.0, 50.0, 0.0), (-2.0, 50.0, 0.0), (-2.0, 27.0, 2.9)]
    )
    body = extrude(side, "z", -9.0, 9.0) - extrude(slot, "y", 20.0, 40.0)
    body -= drill(2.75, "z", (34.0, 30.5), -10.0, 10.0)
    body -= drill(4.75, "z", (34.0, 30.5), 6.5, 10.0)
    body -= drill(3.3, "y", (1.0, 22.0), -1.0, 11.0)
    return surface_of(body)


def bracket() -> Surface:
    """L bracket of 5 mm plate, 50 mm by 42 mm by 36 mm, with a rib and four holes."""
    angle = rounded_polygon(
        [
            (0.0, 0.0, 2.0),
            (50.0, 0.0, 0.0),
            (50.0, 5.0, 0.0),
            (5.0, 5.0, 3.0),
            (5.0, 42.0, 0.0),
            (0.0, 42.0, 0.0),
        ]
    )
    rib = np.array([(3.0, 3.0), (32.0, 3.0), (32.0, 6.0), (6.0, 28.0), (3.0, 28.0)])
    base = rounded_polygon(
        [(-18.0, -1.0, 0.0), (18.0, -1.0, 0.0), (18.0, 50.0, 6.0), (-18.0, 50.0, 6.0)]
    )
    wall = rounded_polygon(
        [(-1.0, -18.0, 0.0), (42.0, -18.0, 6.0), (42.0, 18.0, 6.0), (-1.0, 18.0, 0.0)]
    )
    body = extrude(angle, "z", -18.0, 18.0) + extrude(rib, "z", -2.5, 2.5)
    body ^= extrude(base, "y", -1.0, 43.0) ^ extrude(wall, "x", -1.0, 51.0)
    for z in (-10.0, 10.0):
        body -= drill(2.75, "y", (z, 40.0), -1.0, 6.0)
        body -= drill(2.75, "x", (32.0, z), -1.0, 6.0)
    return surface_of(body)


def hex_bolt() -> Surface:
    """Hexagon head bolt M8 x 30 along z, its head above z = 0, shank 48-sided."""
    head = extrude(13.0 / np.sqrt(3.0) * unit_circle(6), "z", -5.3, 0.0)
    chamfer = np.array(
        [(0.0, -5.3), (6.0, -5.3), (9.0, -5.3 + np.sqrt(3.0)), (9.0, 1.0), (0.0, 1.0)]
    )
    shank = np.array([(0.0, -1.0), (4.0, -1.0), (4.0, 29.0), (3.2, 30.0), (0.0, 30.0)])
    # Its facets face the corners.
    cone = revolve(chamfer, 96).rotate((0.0, 0.0, 180.0 / 96.0))
    return surface_of((head ^ cone) + revolve(shank, 48))


def gear() -> Surface:
    """Spur gear, 32 teeth of module 1, 10 mm wide, with an 8 mm bore and a hub."""
    wheel = extrude(spur_gear(32, 1.0), "z", 0.0, 10.0)
    hub = np.array([(0.0, 5.0), (9.0, 5.0), (9.0, 17.2), (8.2, 18.0), (0.0, 18.0)])
    bore = drill(4.0, "z", (0.0, 0.0), -1.0, 19.0, sides=64)
    return surface_of(wheel + revolve(hub, 64) - bore)


def prism() -> Surface:
    """Hexagonal prism, circumradius 10 mm, length 24 mm."""
    return sort_surface(*profiles.prism(6, 10.0, 24.0))


def cylinder() -> Surface:
    """Cylinder of 64 facets, radius 9 mm, length 22 mm."""
    return sort_surface(*profiles.prism(64, 9.0, 22.0))


DEMO_PARTS: dict[str, Callable[[], Surface]] = {
    make.__name__: make for make in (clamp, bracket, hex_bolt, gear, prism, cylinder)
}
"""Name to a function that makes the part: vertices (V, 3) in mm and triangles (T,
3)."""


def write_demo_parts(directory: str | os.PathLike[str]) -> list[Path]:
    """Write each demo part to `<name>.stl`, binary STL in millimetres, each at once."""
    folder = Path(directory)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        paths = [folder / f"{name}.stl" for name in DEMO_PARTS]
        for path, make in zip(paths, DEMO_PARTS.values(), strict=True):
            files.write_file(path, stl_bytes(*make()))
        return paths
    except OSError as error:
        raise errors.MeshFileError(
            "a directory that can be written to",
            f"{folder} ({error.strerror or error})",
            "name another directory or change its permissions",
        ) from error


def extrude(outline: Outline, axis: str, start: float, stop: float) -> Manifold:
    """Solid over an outline in the two axes that follow `axis` in the cycle x, y, z."""
    solid = CrossSection([outline]).extrude(stop - start).translate((0.0, 0.0, start))
    order = {"x": (2, 0, 1), "y": (1, 2, 0), "z": (0, 1, 2)}[axis]
    return solid.transform(np.eye(3, 4)[list(order)])


def drill(
    radius: float,
    axis: str,
    center: tuple[float, float],
    start: float,
    stop: float,
    sides: int = 32,
) -> Manifold:
    """Drilling tool along an axis; its center as in `extrude`."""
    return extrude(radius * unit_circle(sides) + np.array(center), axis, start, stop)


def revolve(outline: Outline, sides: int) -> Manifold:
    """Solid around z; the outline gives (distance from the axis, z)."""
    return CrossSection([outline]).revolve(sides)


def surface_of(solid: Manifold) -> Surface:
    """Triangles of a solid."""
    mesh = solid.to_mesh64()
    vertices = np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3]
    return sort_surface(vertices, np.asarray(mesh.tri_verts, dtype=np.int64))


def sort_surface(vertices: Array, triangles: Index) -> Surface:
    """Coordinates as float32, in lexicographic order, whatever a modeller's order."""
    rounded = vertices.astype(np.float32).astype(np.float64) + 0.0
    points, index = np.unique(rounded, axis=0, return_inverse=True)
    return points, arrays.sort_triangles(index.reshape(-1)[triangles])
