"""True outlines of a part at rest: its shadow, and its section at a height."""

from typing import TYPE_CHECKING

import numpy as np

from ...base import errors
from .. import tolerances
from ..mesh import arrays, vectors
from ..records import Array, Part, StablePose
from . import convex_body

if TYPE_CHECKING:
    from manifold3d import CrossSection, Manifold

Polygon = tuple[Array, ...]
# Of length in a radius: polygons are kept to 1e-8 of one, and needles are thin.
UNITS = 1e4


def outline_at(
    part: Part, pose: StablePose, height: float | None = None
) -> tuple[Polygon, ...]:
    """Outline of a part at rest in a pose, as seen from above or at a height.

    Unlike `pose.outline`, which is that of the convex hull, it shows bays and holes. It
    is that of the surface as the file has it, closed where the mesh was open.

    Parameters
    ----------
    part : Part
    pose : StablePose
        One of its poses, from `estimate`, `simulate` or `resting_poses`.
    height : float, optional
        Above the plate, metres: the section just above that height. Default: the
        silhouette.

    Returns
    -------
    tuple of polygons
        The largest first; each is a tuple of rings (k, 2) in the plate frame, metres:
        the boundary counter-clockwise from above, then holes clockwise. Empty at
        heights where nothing of the part is.

    Raises
    ------
    RequestError
        If `part` or `pose` are something else, or the height is no finite number.
    MeshError
        If the part's surface is not closed, as that of every Part from a mesh is.
    """
    if not isinstance(part, Part) or not isinstance(pose, StablePose):
        raise errors.RequestError(
            "a Part and one of its poses",
            f"{type(part).__name__} and {type(pose).__name__}",
            "take a pose of estimate(part).poses",
        )
    level = None if height is None else arrays.number_or_nan(height)
    if level is not None and not np.isfinite(level):
        raise errors.RequestError(
            "a height above the plate in metres",
            f"{height!r}",
            "leave it out for the silhouette",
        )
    from manifold3d import JoinType  # only outlines need it

    body = convex_body.body_of(part, 0)
    unit = body.radius / UNITS
    rotation = vectors.rotation_matrices(pose.orientation[None])[0]
    points = vectors.turn_vectors(
        (part.surface_vertices - part.center_of_mass) / unit, rotation.T
    )
    points[:, 2] += pose.height / unit
    flatness = UNITS * (body.tolerance or tolerances.COPLANAR)
    if level is None:
        outline = _solid(part, points).project()
    else:
        level /= unit
        points[np.abs(points[:, 2] - level) <= flatness, 2] = level
        outline = _solid(part, points).slice(level)
    step = min(flatness, UNITS * tolerances.COPLANAR)
    # Walls that stand upright but for rounding leave spurs without any width.
    cleaned = (
        outline.offset(-step, JoinType.Miter, 2.0)
        .offset(step, JoinType.Miter, 2.0)
        .simplify(step)
    )
    polygons = sorted(cleaned.decompose(), key=lambda polygon: -polygon.area())
    return tuple(
        _rings(polygon, unit) for polygon in polygons if not polygon.is_empty()
    )


def _solid(part: Part, points: Array) -> "Manifold":
    from manifold3d import Error, Manifold, Mesh64

    solid = Manifold(
        Mesh64(
            vert_properties=points, tri_verts=part.surface_triangles.astype(np.uint64)
        )
    )
    if solid.status() != Error.NoError:
        raise errors.MeshError(
            "a closed surface",
            f"one that is none ({solid.status().name})",
            "make the part with load_part or part_from_mesh",
        )
    return solid


def _rings(polygon: "CrossSection", unit: float) -> Polygon:
    """Rings of one polygon in metres, its boundary first: holes have areas below 0."""

    def double_area(ring: Array) -> float:
        x, y = ring.T
        return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())

    rings = map(np.asarray, polygon.to_polygons())
    return tuple(ring * unit for ring in sorted(rings, key=double_area, reverse=True))


def area_and_length(outline: Array) -> tuple[float, float]:
    """Area and length of a polygon's boundary."""
    x, y = outline.T
    following_corner = np.roll(outline, -1, axis=0)
    return (
        0.5 * abs(float(x @ following_corner[:, 1] - y @ following_corner[:, 0])),
        float(np.hypot(*(following_corner - outline).T).sum()),
    )
