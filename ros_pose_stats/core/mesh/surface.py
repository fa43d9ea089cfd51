"""From a mesh to the surface of a solid: welded, closed, oriented and integrated."""

from typing import NamedTuple

import numpy as np

from ...base import errors, text
from .. import tolerances
from ..kernels.mesh import measures, nearness
from ..kernels.principal_axes import principal_axes
from ..records import Array, Index
from . import arrays, mass_properties, winding
from .closing import Closing, close_holes
from .hull import Hull, hull_of
from .shells import orient_outward
from .vectors import area_vectors

UNCERTAIN = 1e-3
"""Largest volume, as a fraction of the solid's, that caps of holes may be wrong by, or
that bodies may share without a warning. The centre of mass is then right to a
thousandth of the radius."""


class Surface(NamedTuple):
    """A welded closed surface with the solid in it."""

    vertices: Array  # (W, 3); metres
    triangles: Index  # (U, 3); normals point out of the material
    solid: mass_properties.Solid
    hull: Hull  # of `vertices`
    from_hull: bool  # whether the hull stands in for the part
    warnings: tuple[str, ...]
    notes: tuple[str, ...] = ()


def surface_of(vertices: Array, triangles: Index) -> Surface:
    """Weld, close, orient and integrate.

    Where that gives no solid, take the convex hull.
    """
    vertices, triangles = weld(vertices, triangles)
    _check_spans_volume(vertices, triangles)
    shells = winding.find_shells(vertices, triangles)
    closing = (
        Closing(shells) if shells is not None else close_holes(vertices, triangles)
    )
    problem = closing.problem
    if closing.shells is not None:
        surface = _solid_surface(vertices, closing.shells)
        if not _is_solid(surface.solid, surface.hull):
            problem = "encloses no solid"
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
                    f"HOLES_CLOSED: {text.several(closing.holes, 'hole')} in the mesh "
                    f"{'was' if closing.holes == 1 else 'were'} closed without "
                    f"further corners, which leaves {100.0 * share:.2g} % of the "
                    "volume uncertain; the centre of mass is then at "
                    f"{_describe_centroid(surface.solid, surface.hull)}.",
                    *surface.warnings,
                )
            )
        else:
            return surface
    return _hull_surface(vertices, problem)


def weld(vertices: Array, triangles: Index) -> tuple[Array, Index]:
    """Merge vertices within `WELD` of the extent and drop collapsed triangles.

    Returns the first of coincident vertices; the very array given when nothing changes.
    """
    vertices, triangles = arrays.remove_unused(vertices, triangles)
    if len(triangles) == 0:
        return vertices, triangles
    low, high = measures.bounds(vertices)
    extent = float((high - low).max())
    if extent == 0.0:
        return vertices[:1], triangles[:0]
    has_coincident, representative = nearness.first_of_coincident(
        vertices, low, tolerances.WELD * extent
    )
    if not has_coincident:
        return arrays.remove_unused(vertices, arrays.remove_collapsed(triangles))
    is_kept = representative == np.arange(len(vertices))
    number = np.cumsum(is_kept) - 1
    triangles = arrays.remove_collapsed(number[representative][triangles])
    return arrays.remove_unused(vertices[is_kept], triangles)


def _solid_surface(vertices: Array, shells: winding.Shells) -> Surface:
    """The solid that closed shells bound."""
    points, triangles = arrays.remove_unused(vertices, shells.triangles)
    outward_triangles, doubled_share = orient_outward(
        points, shells._replace(triangles=triangles)
    )
    remark = (
        "BODIES_OVERLAP: bodies of the mesh reach into each other, and "
        f"{100.0 * doubled_share:.2g} % of the volume counts twice in the mass "
        "properties; unite them in CAD or give mass properties.",
    )
    return Surface(
        points,
        np.ascontiguousarray(outward_triangles),
        mass_properties.solid_of(points, outward_triangles),
        hull_of(points),
        False,
        remark if doubled_share > UNCERTAIN else (),
        remark if 0.0 < doubled_share <= UNCERTAIN else (),
    )


def _hull_surface(vertices: Array, problem: str) -> Surface:
    """The hull in place of a mesh that has a problem."""
    hull = hull_of(vertices)
    triangles = _hull_triangles(vertices, hull)
    solid = mass_properties.solid_of(vertices, triangles)
    warning = (
        f"OPEN_MESH: the mesh {problem}, so its convex hull stands in for it, with "
        f"the centre of mass at {_describe_centroid(solid, hull)}; mass properties "
        "that you do not give are the hull's."
    )
    return Surface(vertices, triangles, solid, hull, True, (warning,))


def _describe_centroid(solid: mass_properties.Solid, hull: Hull) -> str:
    """The centroid in words, without rounding errors."""
    is_nonzero = np.abs(solid.centroid) > 1e-6 * hull.scale
    x, y, z = (1e3 * np.where(is_nonzero, solid.centroid, 0.0)).tolist()
    return f"({x:.4g}, {y:.4g}, {z:.4g}) mm"


def _is_solid(solid: mass_properties.Solid, hull: Hull) -> bool:
    """Whether a solid in this hull can have such a volume, centroid and inertia."""
    hull_volume = hull.qhull.volume * (hull.scale * hull.scale * hull.scale)
    return bool(
        solid.volume > tolerances.HOLLOW * hull_volume
        and distance_to_hull(solid.centroid, hull) < 0.0
        and principal_axes(solid.inertia)[0][0] > 0.0
    )


def _hull_triangles(vertices: Array, hull: Hull) -> Index:
    """Triangles of the hull, normals outward."""
    triangles = hull.qhull.simplices.astype(np.int64)
    shells = winding.find_shells(vertices, triangles)
    if shells is not None:
        return arrays.sort_triangles(orient_outward(vertices, shells)[0])
    # Qhull may split a merged facet into slivers that fold, but its normals are right.
    normals = area_vectors(vertices, triangles)
    is_inward = (normals * hull.qhull.equations[:, :3]).sum(axis=1) < 0.0
    return arrays.sort_triangles(
        np.where(is_inward[:, None], triangles[:, ::-1], triangles)
    )


def distance_to_hull(point: Array, hull: Hull) -> float:
    """How far a point is beyond the nearest hull plane, metres; negative inside."""
    planes = hull.qhull.equations
    with np.errstate(over="ignore"):
        position = (point - hull.shift) / hull.scale
        offset = float(np.abs(position).max())
    if offset > 1e9:
        # Perhaps too far to compute with, and the hull is as good as a point.
        return offset * hull.scale
    return float((planes[:, :3] @ position + planes[:, 3]).max() * hull.scale)


def _check_spans_volume(vertices: Array, triangles: Index) -> None:
    """Refuse points that are one point, a line or a plane to within `FLATTEST`."""
    if len(triangles) == 0:
        raise errors.MeshError(
            "triangles that span an area",
            "only triangles with coincident corners",
            "check the mesh's unit and export it again with more digits",
        )
    thinnest = measures.thinness(vertices, *measures.bounds(vertices))
    if thinnest < tolerances.FLATTEST:
        raise errors.MeshError(
            f"a part at least {tolerances.FLATTEST:g} of its length thick",
            f"one that is {thinnest:.2g} of its length thick",
            "give a flat part its real thickness",
        )
