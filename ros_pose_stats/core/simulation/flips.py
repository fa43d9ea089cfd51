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

"""Flips: a feeder's plate kicks parts that lie wrong, and they come to rest anew."""

import math
import time
from collections.abc import Callable, Iterable

import numpy as np

from ...base import errors, version
from ..kernels.drops.layout import P, V, W
from ..mesh.vectors import cross, lengths, turn_vectors
from ..records import Array, DropScene, FlipStatistics, Index, Part
from ..records.notes import note
from ..records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
    HIGHEST_KICK,
    height_warnings,
    real_number,
)
from ..resting.symmetry import pair_orbits
from ..resting.trust import pose_notes
from ..statistics.errors import standard_errors
from . import chunks, drop_body, drops
from .request import UNWATCHED, DropRequest, Watch, drop_request

OnCount = Callable[[int, int], object] | None
"""Takes the number done, and of all."""

DEFAULT_FLIPS = 2000  # flips a pose: a share is told to a point
FLIPS_IN_ALL = 10_000
"""Flips of a kick in a plan, shared out over the poses; a node takes as many."""

LOWEST_KICK_RADII = 0.05
HIGHEST_KICK_RADII = 5.0
KICKS = 13
"""Part radii, and how many between them: below the lowest hardly a part leaves its
pose, above the highest most come to rest as if dropped."""

MOST_KICK_RADII = 1e6
"""Part radii, above which a flip ends by chance alone, after some hundred thousand
events."""

SAME_DIRECTION = 2.0**-20  # to which directions are rounded before they are ordered


def simulate_flips(
    part: Part,
    kick_height: float,
    drops: int = DEFAULT_FLIPS,
    restitution: float = DEFAULT_RESTITUTION,
    seed: int | None = None,
    workers: int | None = None,
    on_progress: OnCount = None,
    should_stop: Callable[[], bool] | None = None,
    *,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
    background: bool = False,
) -> FlipStatistics:
    """Kick a part out of each of its poses, and count where it comes to rest.

    Parameters
    ----------
    part : Part
    kick_height : float
        Energy of a kick over the weight, metres, 0 or more: as high would it lift the
        part without turning it. The plate hits the part at a point of its contact
        polygon, drawn uniformly.
    drops : int
        Flips out of each pose, from 1.
    restitution : float
        Of the plate on which the part falls back, 0 <= restitution < 1.
    seed : int, optional
        Flip k out of a pose depends on seed, k and the part alone. Default: a fresh
        one.
    workers : int, optional
        Threads; default: all cores.
    on_progress : callable, optional
        Takes the number of flips done, and of all.
    should_stop : callable, optional
        Once it returns True the simulation ends with the flips done by then.
    cluster_tolerance, round_sides, background
        As for `simulate`.

    Returns
    -------
    FlipStatistics

    Raises
    ------
    RequestError, MeshError
        If a value is out of range, or the part's hull does not enclose its centre of
        mass.
    """
    return count_flips(
        part,
        DropScene(restitution, None, cluster_tolerance, round_sides),
        kick_height,
        drop_request(drops, seed, 0.0, workers),
        Watch.from_callbacks(None, should_stop, None, background),
        on_progress,
    )


def count_flips(
    part: Part,
    scene: DropScene,
    kick_height: float,
    per_pose: DropRequest,
    watch: Watch,
    on_progress: OnCount = None,
) -> FlipStatistics:
    """Flip a part in a scene, out of each pose as requested; see `simulate_flips`."""
    begin = time.perf_counter()
    part.require_known_error("flips")
    body = drop_body.drop_body(part, scene)
    kick = check_kick(kick_height, body.radius)
    poses = body.resting.poses
    request = drop_request(
        per_pose.drops * len(poses), per_pose.seed, 0.0, per_pose.workers
    )
    outcomes = _count_outcomes(body, scene, kick, request, watch, on_progress)
    counts = outcomes[:, 1:]
    unsettled = outcomes[:, 0]
    transition, errors, effective_counts = pool_flips(counts, body.resting.symmetries)
    warnings = [
        *part.warnings,
        *pose_notes(body.resting),
        *height_warnings("kick", kick, body.radius, HIGHEST_KICK),
    ]
    if unsettled.any():
        warnings.append(
            note(
                "UNSETTLED",
                f"{unsettled.sum()} of {outcomes.sum()} flips were given up before "
                "their pose was certain; they are left out of the probabilities.",
            )
        )
    return FlipStatistics(
        part_id=part.part_id,
        part_digest=part.digest,
        radius=body.radius,
        restitution=scene.restitution,
        kick_height=kick,
        cluster_tolerance=scene.cluster_tolerance,
        round_sides=scene.round_sides,
        poses=poses,
        counts=counts,
        effective_counts=effective_counts,
        unsettled=unsettled,
        transition=transition,
        standard_error=errors,
        seed=request.seed,
        seconds=time.perf_counter() - begin,
        warnings=tuple(warnings),
        version=version.VERSION,
    )


def pool_flips(counts: Index, symmetries: Index) -> tuple[Array, Array, Array]:
    """Probabilities (K, K) of flips, their errors, and counts that would tell as much.

    A motion that carries the part into itself takes pose i to s[i], and T[i, j] is
    T[s[i], s[j]]: what was counted of such pairs is taken together. `counts` (K, K);
    `symmetries` (S, K).
    """
    orbit = pair_orbits(symmetries)
    poses = len(counts)
    settled = counts.sum(axis=1)
    # Of the pairs that motions make of one, as many leave each of its poses.
    pose_orbit = np.diagonal(orbit)
    settled = np.bincount(pose_orbit, settled)[pose_orbit]
    pooled = np.bincount(orbit.ravel(), counts.ravel())[orbit]
    pairs = np.stack(
        [np.bincount(row, minlength=orbit.max() + 1)[row] for row in orbit]
    )
    with np.errstate(invalid="ignore"):
        transition = pooled / pairs / settled[:, None]
    rows = zip(pooled, settled.tolist(), pairs, strict=True)
    errors = [standard_errors(row, total) / number for row, total, number in rows]
    return transition, np.reshape(errors, (poses, poses)), pooled / pairs


def flips_by_kick(
    part: Part,
    scene: DropScene,
    kicks: Iterable[float],
    per_pose: DropRequest,
    watch: Watch = UNWATCHED,
    on_kick: OnCount = None,
) -> list[FlipStatistics]:
    """Flips at several kick heights, at the same points, as far as complete."""
    # What is refused is refused before the first flip.
    heights = sorted(
        {check_kick(kick, drop_body.drop_body(part, scene).radius) for kick in kicks}
    )
    results = []
    for number, height in enumerate(heights):
        if on_kick is not None:
            on_kick(number, len(heights))
        flips = count_flips(part, scene, height, per_pose, watch)
        if flips.flips < per_pose.drops * len(flips.poses):
            break
        results.append(flips)
    return results


def check_kick(kick_height: float, radius: float = math.inf) -> float:
    """A kick height as a number, for a part of this radius in metres, if known."""
    kick = real_number("kick_height", kick_height)
    highest = MOST_KICK_RADII * radius
    if not 0.0 <= kick < math.inf or kick > highest:
        bound = f" and at most {highest:.3g} m" if highest < math.inf else ""
        raise errors.RequestError(
            f"a kick height of 0 m or more{bound}",
            f"{kick_height}",
            "half the part's radius flips most parts",
        )
    return kick


def flips_per_pose(poses: int, number: int | None) -> int:
    """Flips out of each pose of a part: their number, or the usual one."""
    return max(1, FLIPS_IN_ALL // poses) if number is None else number


def usual_kicks(radius: float) -> tuple[float, ...]:
    """Kick heights, metres, worth looking at for a part of this radius, metres."""
    return tuple(
        (radius * np.geomspace(LOWEST_KICK_RADII, HIGHEST_KICK_RADII, KICKS)).tolist()
    )


def _count_outcomes(
    body: drop_body.PreparedBody,
    scene: DropScene,
    kick: float,
    request: DropRequest,
    watch: Watch,
    on_progress: OnCount,
) -> Index:
    """Flips (K, 1 + K) out of each pose: given up, and into each pose."""
    poses = len(body.resting.poses)
    rules = drops.drop_rules(scene, body.radius)
    kicks = Kicks(body, kick / body.radius)

    def flip(first: int, count: int) -> drops.DropOutcomes:
        return drops.compute_motions(
            body, rules, kicks.states(request.seed, first, count)
        )

    workers = chunks.DropWorkers(
        flip, request.drops, request.workers, watch.should_stop, watch.background
    )
    flip_counts = np.zeros(poses * (1 + poses), dtype=np.int64)
    flips_done = 0
    for outcomes in workers.outcomes_in_order():
        flips = outcomes.pose.shape[0]
        end = flips_done + flips
        row = kicks.poses(flips_done, flips)
        flip_counts += np.bincount(
            row * (1 + poses) + outcomes.pose + 1, minlength=flip_counts.shape[0]
        )
        flips_done = end
        if on_progress is not None:
            on_progress(flips_done, request.drops)
    return flip_counts.reshape(poses, 1 + poses)


class Kicks:
    """A plate that kicks the part in any pose at points of its contact polygon.

    `height`: energy of a kick over the weight, radii.
    """

    def __init__(self, body: drop_body.PreparedBody, height: float) -> None:
        self.body = body
        self.height = drops.round_length(height)
        resting = body.resting
        self.directions = drop_body.round_to(
            turn_vectors(resting.downs, body.frame), 2.0**-drop_body.POINT_BITS
        )
        # Flips are numbered through the poses in an order that no turn changes.
        self.order = np.lexsort(drop_body.round_to(self.directions, SAME_DIRECTION).T)
        rows: list[tuple[Array, ...]] = []
        for pose, face in enumerate(resting.faces.tolist()):
            polygon = turn_vectors(_polygon_from_its_first(body, face), body.turn)
            first = polygon[1:-1] - polygon[0]
            second = polygon[2:] - polygon[0]
            cumulative_area = np.cumsum(lengths(np.cross(first, second)))
            share = np.concatenate(([0.0], cumulative_area / cumulative_area[-1]))
            rows.append(
                (
                    np.broadcast_to(polygon[0], first.shape),
                    first,
                    second,
                    pose + share[1:],
                    pose + share[:-1],
                )
            )
        # Triangles of the contact polygons, in principal axes: a corner (T, 3) and the
        # sides that leave it, then (T,) the share of the polygon's area that it and
        # those before it have, plus the pose's index, and the same without itself.
        # Where corners lie on one line both are equal.
        self.corner, self.first, self.second, self.end, self.begin = map(
            np.concatenate, zip(*rows, strict=True)
        )

    def poses(self, first: int, count: int) -> Index:
        """Poses (count,) out of which flips from `first` on are."""
        numbers = np.arange(first, first + count) % self.order.shape[0]
        return np.asarray(self.order[numbers])

    def states(self, seed: int, first: int, count: int) -> Array:
        """States (count, 8) just after kicks from `first` on, all poses in turn.

        A vertical impulse J acts at a point r drawn uniformly from the contact polygon:
        v = J / m and w = J I^-1 (r x up), with J such that the energy is m g times the
        height.
        """
        resting = self.body.resting
        moment = self.body.arrays.moment
        pose = self.poses(first, count)
        states = drops.states_at_rest(
            self.body, resting.heights[pose], self.directions[pose]
        )
        points = self._points(pose, drops.flip_draws(seed, first, count))
        arm = cross(points, states[:, P : P + 3])
        reach = arm * arm / moment
        impulse = np.sqrt(
            2.0 * self.height / (1.0 + reach[:, 0] + reach[:, 1] + reach[:, 2])
        )
        states[:, V] = impulse
        states[:, W : W + 3] = impulse[:, None] * arm / moment
        return states

    def _points(self, pose: Index, draws: Array) -> Array:
        """Points (n, 3) of contact polygons from two uniform numbers each."""
        triangle = np.searchsorted(self.end, pose + draws[:, 0], side="right")
        # A sum that rounds up would be the next pose's.
        triangle = np.minimum(
            triangle, np.searchsorted(self.end, pose + 1.0, side="left")
        )
        size = self.end[triangle] - self.begin[triangle]
        share = np.clip((pose + draws[:, 0] - self.begin[triangle]) / size, 0.0, 1.0)
        side_share = share[:, None]
        outward_share = np.sqrt(draws[:, 1:])
        return np.asarray(
            self.corner[triangle]
            + outward_share
            * (
                (1.0 - side_share) * self.first[triangle]
                + side_share * self.second[triangle]
            )
        )


def _polygon_from_its_first(body: drop_body.PreparedBody, face: int) -> Array:
    """Corners (k, 3) of a face in axes of the body's frame, counter-clockwise there.

    They begin at one that neither the order of the mesh nor a turn changes.
    """
    arrays = body.resting.body.arrays
    sides = slice(arrays.face_start[face], arrays.face_start[face + 1])
    polygon = body.frame_points(arrays.corner[sides])
    if drop_body.is_left_handed(body.frame):
        polygon = polygon[::-1]
    return np.roll(polygon, -int(np.lexsort(polygon.T)[0]), axis=0)
