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

"""From a welded mesh to the surface of a solid: closed, oriented and integrated."""

import math
from typing import NamedTuple

import numpy as np

from ...base import errors, text
from .. import tolerances
from ..kernels.mesh.measures import solid_moments, thinness
from ..kernels.principal_axes import principal_axes
from ..records import Array, Index
from ..records.notes import Note, note
from . import arrays, winding
from .bodies.crossing import share_enclosed_twice
from .bodies.looseness import has_loose_bodies
from .closing import Closing, close_holes
from .hull import Hull, distance_to_hull, hull_of
from .shells import orient_outward
from .vectors import UnitPoints, area_vectors, to_unit_size

UNCERTAIN = 1e-3
"""Largest volume, as a fraction of the solid's, that caps of holes may be wrong by, or
that bodies may share without a warning. The centre of mass is then right to a
thousandth of the radius."""

ROUNDED_OFF = 1e-9
"""A solid whose volume is this close to its hull's is convex, and does not run through
itself; one that does may have more."""


class Solid(NamedTuple):
    """A solid of density one."""

    volume: float  # m³; negative when the surface is wound inward
    centroid: Array  # (3,); metres; NaN when the volume is zero
    inertia: Array  # (3, 3); about the centroid, m⁵ (times a density: kg m²)


def solid_of(scaled: UnitPoints, triangles: Index) -> Solid:
    """Integrate over the solid that a closed surface of points at unit size encloses.

    It is split into tetrahedra from one common apex; their signed volumes, first and
    second moments are polynomials in the vertices and add up exactly (divergence
    theorem). With the apex in the centre of the bounding box, and lengths in its size,
    neither the place of the part nor its unit costs digits. Powers are written as
    products, for the C library's round differently on other processors.
    """
    points, shift, scale = scaled
    volume, *moments = solid_moments(points, np.ascontiguousarray(triangles)).tolist()
    if volume == 0.0:
        return Solid(0.0, np.full(3, math.nan), np.full((3, 3), math.nan))
    x, y, z = (moment / volume for moment in moments[:3])
    xx, yy, zz, xy, xz, yz = moments[3:]
    xx = xx - volume * x * x
    yy = yy - volume * y * y
    zz = zz - volume * z * z
    xy = xy - volume * x * y
    xz = xz - volume * x * z
    yz = yz - volume * y * z
    inertia = np.array([[yy + zz, -xy, -xz], [-xy, xx + zz, -yz], [-xz, -yz, xx + yy]])
    cube = scale * scale * scale
    return Solid(
        volume * cube,
        shift + scale * np.array([x, y, z]),
        inertia * (cube * scale * scale),
    )


class Surface(NamedTuple):
    """A welded closed surface with the solid in it."""

    vertices: Array  # (W, 3); metres
    triangles: Index  # (U, 3); normals point out of the material
    solid: Solid
    hull: Hull  # of `vertices`
    # why the hull stands in for the part, to go on from "the mesh"; empty where it
    # does not
    problem: str
    warnings: tuple[Note, ...]


def surface_of(
    vertices: Array, triangles: Index, widest_hole: float = math.inf
) -> Surface:
    """Close, orient and integrate a welded mesh.

    Where that gives no solid, take the convex hull. `widest_hole`: that may be closed,
    as a fraction of the size.
    """
    _check_area(triangles)
    scaled = to_unit_size(vertices)
    _check_thickness(scaled.points)
    shells = winding.find_shells(vertices, triangles)
    closing = (
        Closing(shells)
        if shells is not None
        else close_holes(vertices, scaled, triangles)
    )
    problem = closing.problem
    if closing.shells is not None:
        surface = _solid_surface(vertices, closing.shells)
        if not _is_solid(surface.solid, surface.hull):
            problem = "encloses no solid"
        elif closing.width > widest_hole:
            problem = (
                f"has {text.several(closing.holes, 'hole')}, wider than a crack "
                "between faces"
            )
        elif closing.open_volume > UNCERTAIN * surface.solid.volume:
            share = closing.open_volume / surface.solid.volume
            problem = (
                f"has {text.several(closing.holes, 'hole')}, whose caps may be wrong "
                f"by {100.0 * share:.2g} % of the volume"
            )
        elif closing.holes:
            share = closing.open_volume / surface.solid.volume
            return surface._replace(
                warnings=(
                    note(
                        "HOLES_CLOSED",
                        f"{text.several(closing.holes, 'hole')} in the mesh "
                        f"{'was' if closing.holes == 1 else 'were'} closed without "
                        f"further corners, which leaves {100.0 * share:.2g} % of the "
                        "volume uncertain; the centre of mass is then at "
                        f"{_describe_centroid(surface.solid, surface.hull)}.",
                    ),
                    *surface.warnings,
                )
            )
        else:
            return surface
    return _hull_surface(vertices, scaled, problem)


def _solid_surface(vertices: Array, shells: winding.Shells) -> Surface:
    """The solid that closed shells bound."""
    points, triangles = arrays.remove_unused(vertices, shells.triangles)
    scaled = to_unit_size(points)
    material = orient_outward(scaled.points, shells._replace(triangles=triangles))
    solid = solid_of(scaled, material.triangles)
    hull = hull_of(scaled)
    doubled_share = material.doubled_share
    finding = "bodies of the mesh reach into each other"
    hull_volume = _hull_volume(hull)
    is_convex = abs(solid.volume - hull_volume) < ROUNDED_OFF * hull_volume
    if doubled_share == 0.0 and not is_convex:
        doubled_share = share_enclosed_twice(scaled.points, material.triangles)
        finding = "the mesh runs through itself"
    warnings = []
    if doubled_share > 0.0:
        overlap = note(
            "BODIES_OVERLAP",
            f"{finding}, and {100.0 * doubled_share:.2g} % of the volume counts twice "
            "in the mass properties; unite what overlaps in CAD or give mass "
            "properties.",
        )
        # The centre of mass is close enough where little counts twice.
        warnings.append(overlap._replace(acts=doubled_share > UNCERTAIN))
    if material.body is not None and has_loose_bodies(
        scaled.points, material.triangles, material.body
    ):
        warnings.append(
            note(
                "BODIES_LOOSE",
                "bodies of the mesh do not touch each other; they are one rigid part "
                "here, though what is loose moves in a drop.",
            )
        )
    return Surface(
        points,
        np.ascontiguousarray(material.triangles),
        solid,
        hull,
        "",
        tuple(warnings),
    )


def _hull_surface(vertices: Array, scaled: UnitPoints, problem: str) -> Surface:
    """The hull in place of a mesh that has a problem."""
    hull = hull_of(scaled)
    triangles = _hull_triangles(vertices, hull)
    solid = solid_of(scaled, triangles)
    warning = note(
        "OPEN_MESH",
        f"the mesh {problem}, so its convex hull stands in for it, with the centre of "
        f"mass at {_describe_centroid(solid, hull)}; mass properties that you do not "
        "give are the hull's.",
    )
    return Surface(vertices, triangles, solid, hull, problem, (warning,))


def _describe_centroid(solid: Solid, hull: Hull) -> str:
    """The centroid in words, without rounding errors."""
    is_nonzero = np.abs(solid.centroid) > 1e-6 * hull.scale
    x, y, z = (1e3 * np.where(is_nonzero, solid.centroid, 0.0)).tolist()
    return f"({x:.4g}, {y:.4g}, {z:.4g}) mm"


def _hull_volume(hull: Hull) -> float:
    """Cubic metres; as products, as in `solid_of`."""
    return hull.qhull.volume * (hull.scale * hull.scale * hull.scale)


def _is_solid(solid: Solid, hull: Hull) -> bool:
    """Whether a solid in this hull can have such a volume, centroid and inertia."""
    return bool(
        solid.volume > tolerances.HOLLOW * _hull_volume(hull)
        and distance_to_hull(solid.centroid, hull) < 0.0
        and principal_axes(solid.inertia)[0][0] > 0.0
    )


def _hull_triangles(vertices: Array, hull: Hull) -> Index:
    """Triangles of the hull, normals outward."""
    triangles = hull.qhull.simplices.astype(np.int64)
    shells = winding.find_shells(vertices, triangles)
    if shells is not None:
        return arrays.sort_triangles(
            orient_outward(hull.qhull.points, shells).triangles
        )
    # Qhull may split a merged facet into slivers that fold, but its normals are right.
    normals = area_vectors(vertices, triangles)
    is_inward = (normals * hull.qhull.equations[:, :3]).sum(axis=1) < 0.0
    return arrays.sort_triangles(
        np.where(is_inward[:, None], triangles[:, ::-1], triangles)
    )


def _check_area(triangles: Index) -> None:
    """Refuse a mesh of which welding has left no triangles."""
    if len(triangles) == 0:
        raise errors.MeshError(
            "triangles that span an area",
            "only triangles with coincident corners",
            "check the mesh's unit and export it again with more digits",
        )


def _check_thickness(points: Array) -> None:
    """Refuse points of size one that lie in a plane to within `FLATTEST`."""
    thinnest = thinness(points)
    if thinnest < tolerances.FLATTEST:
        raise errors.MeshError(
            f"a part at least {tolerances.FLATTEST:g} of its length thick",
            f"one that is {thinnest:.2g} of its length thick",
            "give a flat part its real thickness",
        )
