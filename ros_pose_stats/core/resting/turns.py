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

"""How a part can be turned in a pose: by rolling, and about the vertical."""

import math
from collections.abc import Callable

import numpy as np

from ..kernels.body.standing import LEAN, faces_on_roll
from ..kernels.features.curves import curves
from ..kernels.principal_axes import is_kept, principal_axes
from ..mesh.vectors import components_along, cross, length, lengths, scatter
from ..records import Array, Index, Mask, Part
from ..tolerances import SYMMETRY
from . import convex_body, symmetry
from .equilibria import Clusters, Equilibria

# Cosine of an axis' angle to the vertical above which a turn about it is no roll
UPRIGHT = 0.985
LARGEST_STEP = np.radians(24.8)  # facets of a round surface turn by less
LARGEST_PITCH = 2.0 * LARGEST_STEP  # teeth of a toothed one: a tip and a gap
QUARTER_TURN = np.pi / 2.0
FEWEST_LOW = 3  # faces that a part which rolls by that stands on
SAME_AXIS = 1e-3  # sine of the angle within which axes of runs are one
LEVEL = 1e-4  # sine of the angle to the axis within which a facet is along it
NEAR = 0.05  # share of its radius within which a facet is one of a round surface


def measure_axis_offsets(
    body: convex_body.ConvexBody, pose_of_face: Index, downs: Array
) -> Array:
    """How far (P,) the centre of mass is beside axes of full cylinders of poses."""
    normal = body.arrays.normal
    distance = body.arrays.distance
    offsets = np.zeros(len(downs))
    for run in body.runs:
        if run.kind != "round" or not run.full:
            continue
        on_cylinder = (body.run_of_face >= 0) & (
            np.abs(components_along(normal, run.axis)) < LEVEL
        )
        on_cylinder &= (
            np.abs(distance - components_along(normal, run.center) - run.radius)
            < NEAR * run.radius
        )
        # A flat that facets of a thin rim lead to does not roll.
        on_cylinder &= np.abs(components_along(downs, run.axis))[pose_of_face] < UPRIGHT
        offset = length(
            run.center - components_along(run.center[None], run.axis) * run.axis
        )
        np.maximum.at(offsets, pose_of_face[on_cylinder], offset)
    return offsets


def measure_curves(
    body: convex_body.ConvexBody,
    inertia: Array,
    pose_of_face: Index,
    lowest: Index,
    downs: Array,
) -> tuple[Array, Array]:
    """Share (P,) of curves in what leads to poses, and how far (P,) they lie across.

    `inertia` (3, 3): over mass and squared radius; `lowest` (P,): faces that poses rest
    on.
    """
    return curves(
        body.points,
        body.arrays,
        inertia,
        _on_full_turns(body),
        pose_of_face,
        lowest,
        downs,
    )


def _on_full_turns(body: convex_body.ConvexBody) -> Mask:
    """Which faces (F,) touch a run of a full turn, also those of a dome over it."""
    arrays = body.arrays
    on_full_turn = np.zeros(body.faces, dtype=np.bool_)
    for run in body.runs:
        if run.full:
            cosine = components_along(arrays.normal, run.axis)
            reach = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0)) * run.radius
            on_full_turn |= (
                np.abs(
                    arrays.distance
                    - components_along(arrays.normal, run.center)
                    - reach
                )
                < NEAR * run.radius
            )
    return on_full_turn


def rolling_axes(equilibria: Equilibria, clusters: Clusters) -> tuple[Mask, Array]:
    """Which poses roll: go on by 90 degrees about an axis and stay low.

    That axis too (P, 3), of either sign; zero where there is none, or several.
    """
    body = equilibria.body
    rolls = np.zeros(len(clusters.lowest_face), dtype=np.bool_)
    axis = np.zeros((len(rolls), 3))
    pose_of_face = clusters.pose[equilibria.rank][equilibria.arrays.basin]
    limit = (1.0 + clusters.tolerance) * equilibria.heights[clusters.lowest_face]
    is_low = body.arrays.distance <= limit[pose_of_face]
    low_faces = np.bincount(pose_of_face[is_low], minlength=len(rolls))
    run_axes = _distinct_axes(body)
    for pose in np.flatnonzero(low_faces >= FEWEST_LOW).tolist():
        rolled_axes = [
            axis for axis in run_axes if _rolls_about(axis, equilibria, clusters, pose)
        ]
        if not rolled_axes:
            candidate = _axis_of_supports(equilibria, clusters, pose)
            if not _rolls_about(candidate, equilibria, clusters, pose):
                continue
            rolled_axes = [candidate]
        rolls[pose] = True
        if (lengths(cross(np.array(rolled_axes), rolled_axes[0])) < LEAN).all():
            axis[pose] = rolled_axes[0]
    return rolls, axis


def _distinct_axes(body: convex_body.ConvexBody) -> list[Array]:
    """Axes of runs, each once."""
    distinct_axes = []
    axes = np.array([run.axis for run in body.runs])
    while len(axes):
        distinct_axes.append(axes[0])
        axes = axes[lengths(cross(axes, axes[0])) > SAME_AXIS]
    return distinct_axes


def _axis_of_supports(equilibria: Equilibria, clusters: Clusters, pose: int) -> Array:
    """Axis that the faces which a part rests on in a pose turn about.

    A spring has no run, for its corners lie on a helix.
    """
    downs = equilibria.downs[clusters.is_support & (clusters.pose == pose)]
    offsets = downs - downs.mean(axis=0)
    return principal_axes(scatter(offsets))[1][:, 0].copy()


def _rolls_about(
    axis: Array, equilibria: Equilibria, clusters: Clusters, pose: int
) -> bool:
    """Whether a pose goes on by 90 degrees about an axis from tooth to tooth."""
    body = equilibria.body
    lowest = int(equilibria.faces[clusters.lowest_face[pose]])
    down = body.arrays.normal[lowest]
    if abs(float((down * axis).sum())) >= UPRIGHT:
        return False
    low = (1.0 + clusters.tolerance) * body.arrays.distance[lowest]
    over_tooth = (1.0 + clusters.run_tolerance) * body.arrays.distance[lowest]
    is_reached = faces_on_roll(
        body.arrays, body.run_of_face, lowest, axis, low, over_tooth
    )
    is_reached &= body.arrays.distance <= low
    if np.count_nonzero(is_reached) < FEWEST_LOW:
        return False
    normal = body.arrays.normal[is_reached]
    across = cross(axis, down)
    forth = cross(across, axis)
    angles = np.sort(
        np.arctan2(components_along(normal, across), components_along(normal, forth))
    )
    return _longest_stretch(angles) >= QUARTER_TURN


def _longest_stretch(angles: Array) -> float:
    """Largest range of rising angles whose neighbours are as near as teeth."""
    steps = np.diff(angles, append=angles[0] + 2.0 * np.pi)
    if (steps <= LARGEST_PITCH).all():
        return 2.0 * np.pi
    ends = np.flatnonzero(steps > LARGEST_PITCH)
    begins = (np.roll(ends, 1) + 1) % len(angles)
    ranges = angles[ends] - angles[begins]
    return float((ranges % (2.0 * np.pi)).max())


def yaw_symmetries(
    part: Part,
    equilibria: Equilibria,
    lowest: Index,
    trial: Callable[[], symmetry.SurfaceTrial],
) -> Index:
    """Turns about the vertical (P,) that leave the part in a pose as it is.

    n-fold; 1 for no symmetry, and in doubt; 0 for any angle, where all that is turned
    is round.
    """
    order_of_pose = np.ones(len(lowest), dtype=np.int64)
    # The surface has the file's own facets alone.
    original = convex_body.body_of(part, 0)
    for pose, face in enumerate(lowest.tolist()):
        facet = int(
            components_along(original.arrays.normal, equilibria.downs[face]).argmax()
        )
        axis = original.arrays.normal[facet]
        if not is_kept(part.inertia, _turn_matrix(axis, np.pi), SYMMETRY):
            continue  # whose axis would be a principal one
        runs = [
            run
            for run in equilibria.body.runs
            if run.full
            and abs(float(components_along(axis[None], run.axis)[0])) > 1.0 - SYMMETRY
        ]
        corners = int(
            original.arrays.face_start[facet + 1] - original.arrays.face_start[facet]
        )
        order = _order(part, axis, {corners, *(run.corners for run in runs)}, trial)
        is_round = (
            runs and order * LARGEST_STEP > 2.0 * np.pi and trial().is_turned(axis)
        )
        order_of_pose[pose] = 0 if is_round else order
    return order_of_pose


def _order(
    part: Part,
    axis: Array,
    divisions: set[int],
    trial: Callable[[], symmetry.SurfaceTrial],
) -> int:
    """Order of the symmetry about an axis, one that divides one of these numbers."""
    orders = {
        order
        for sides in divisions
        for order in range(2, sides + 1)
        if sides % order == 0
    }
    for order in sorted(orders, reverse=True):
        turn = _turn_matrix(axis, 2.0 * np.pi / order)
        if not is_kept(part.inertia, turn, SYMMETRY):
            continue
        if trial().holds(turn):
            return order
    return 1


def _turn_matrix(axis: Array, angle: float) -> Array:
    """Turn (3, 3) by an angle, radians, about a unit axis (Rodrigues)."""
    cos = math.cos(angle)
    sin = math.sin(angle)
    x, y, z = axis.tolist()
    a = (1.0 - cos) * x
    b = (1.0 - cos) * y
    c = (1.0 - cos) * z
    return np.array(
        [
            (a * x + cos, a * y - sin * z, a * z + sin * y),
            (b * x + sin * z, b * y + cos, b * z - sin * x),
            (c * x - sin * y, c * y + sin * x, c * z + cos),
        ]
    )
