"""How close a body is to another answer: what may excuse a broken invariant, and nothing else."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ros_pose_stats import Part
from ros_pose_stats.mesh.hull import hull_of_part
from ros_pose_stats.resting.convex_body import ConvexBody
from ros_pose_stats.resting.equilibria import equilibria
from ros_pose_stats.resting.poses import RestingPoses
from ros_pose_stats.tolerances import WELD

MARGINAL = 1e-8
"""A foot this close to a side or a corner, in radii: ten times what counts as on it."""


def marginal(part: Part) -> float:
    """Distance of the nearest foot from a side or corner, in radii.

    At 0 an equilibrium is about to vanish: a stable face and a saddle, or a saddle and an
    unstable corner.
    """
    arrays = equilibria(part, 0).body.arrays
    return float(min(np.abs(lengths).min()
                     for lengths in (arrays.inset, arrays.start, arrays.stop)))


def roughness(body: ConvexBody) -> float:
    """How far hull points are off the nearest of the faces, and corners off their own, in radii.

    0 but for rounding, unless triangles were merged that are not quite coplanar.
    """
    arrays = body.arrays
    off = np.abs(body.points @ arrays.normal.T - arrays.distance).min(axis=1).max()
    corners = np.einsum("sx,sx->s", body.points[arrays.corner], arrays.normal[arrays.face])
    return float(max(off, np.abs(corners - arrays.distance[arrays.face]).max()))


def bend(body: ConvexBody) -> float:
    """How far the flattest of all neighbours are from being coplanar, in radii.

    For each side the third of the neighbour's corners, by distance from this face's plane: two
    are the side's own.
    """
    arrays = body.arrays
    least = np.inf
    for side, twin in enumerate(arrays.twin.tolist()):
        face = arrays.face[side]
        off = body.polygon(int(arrays.face[twin])) @ arrays.normal[face] - arrays.distance[face]
        least = min(least, float(np.sort(np.abs(off))[2]))
    return least


def thickness(part: Part) -> float:
    """Smallest spread of the hull points over the largest."""
    hull = hull_of_part(part).qhull
    points = hull.points[hull.vertices]
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return float(spread[2] / spread[0])


def gap(part: Part) -> float:
    """Distance of the two nearest vertices, as a fraction of the extent."""
    vertices = part.surface_vertices
    distance, _ = cKDTree(vertices).query(vertices, k=2)
    return float(distance[:, 1].min() / np.ptp(vertices, axis=0).max())


def smallest_split(resting: RestingPoses) -> float:
    """Least solid angle of a component that falls apart, just before it does, steradians.

    It is a difference of solid angles of up to 4 pi, and decides with which probabilities the
    two halves are reached.
    """
    wanted = resting.clusters.split
    areas = [passage[0][wanted].sum(axis=1).min(initial=np.inf)
             for passage in (resting.passage_r, resting.passage_R)]
    return float(min(areas))


def undecided(part: Part) -> str:
    """Why rounding may decide what the poses are; empty where it cannot.

    A foot within a thousand times of what counts as on a side, or triangles that are merged, or
    not, with less than a factor of five between their bend and the tolerance; vertices so close
    that a corner and the middle of an edge would be welded.
    """
    body = equilibria(part, 0).body
    if marginal(part) < 100.0 * MARGINAL:
        return "marginal"
    if roughness(body) > 0.2 * body.tolerance or bend(body) < 5.0 * body.tolerance:
        return "nearly coplanar"
    if gap(part) < 4.0 * WELD:
        return "nearly coincident"
    return ""
