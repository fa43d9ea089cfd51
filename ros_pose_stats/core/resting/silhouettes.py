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

"""Which poses of a part look alike from above, by their silhouettes at the best yaw."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...base import errors
from ..mesh import arrays
from ..records import Array, Part, PoseStatistics, StablePose
from ..records.statistics import require_same_part
from . import outlines

if TYPE_CHECKING:
    from manifold3d import CrossSection

ALIKE = 0.01
"""Share of its area by which a silhouette may differ from one that it is like."""

FINEST = 5e-4
"""The least share, however small the pixels: what follows is below it."""

CHORD = 4e-4
"""Of area over length: curves of an outline may be cut that far, of a disc into 160
edges, which takes at most two thirds of that share of its area. Fine outlines have
thousands of corners, and each look at a pair takes them all."""

FITTED = 1e-3  # of the open area, to which the best fit is found

RAYS = 1024
RINGS = 64
REACH = 1.25 * outlines.UNITS
CELL = np.pi * REACH * REACH / (RAYS * RINGS)
"""Directions, and rings of one area up to a reach, in which silhouettes are looked at
in all yaws, and the area of a ring between two rays. What is beyond is not seen there.
"""

MOST_YAWS = 4
MOST_FITTED_YAWS = 2
"""Of the yaws in which two silhouettes come near, the best, and the best of these."""

MOST_GROUPS = 32
MOST_FITTED = 24
"""Groups that are looked at, the likeliest, and pairs of them that are laid on each
other as well as can be: of a pebble with more poses all look nearly alike, and it would
take many seconds. Pairs beyond these are laid centroid on centroid."""


def find_lookalikes(
    statistics: PoseStatistics, part: Part, pixel: float | None = None
) -> PoseStatistics:
    """Find the poses that a camera above the plate cannot tell apart.

    Two poses look alike if their silhouettes, one of them moved and turned on the plate
    but not mirrored, differ by less area than is open. A silhouette is the shadow of
    the part as its file has it, seen along the vertical: bays and holes that go through
    count, pockets and colours do not. Poses of one `group` always look alike. The
    relation is one of pairs: of three poses the outer two may differ.

    A picture shows an outline to a pixel. Two pictures of the same outline, with pixels
    that lie anyhow, differ by up to half a pixel along all of it: length x pixel / 2 of
    area is open, of the shorter outline. It is never less than 0.05 % of the smaller
    silhouette. Without a pixel 1 % of that is open, which is what a square of 200
    pixels a side leaves. A pose in which the part rolls is seen as it lies lowest, and
    of more than 32 groups the likeliest are looked at.

    Parameters
    ----------
    statistics : PoseStatistics
        Of the part, by any method.
    part : Part
    pixel : float, optional
        Side of what a pixel of the camera shows of the plate, metres, above 0.

    Returns
    -------
    PoseStatistics
        The same with `alike_from_above` of the poses filled in.

    Raises
    ------
    RequestError
        If the statistics are of another part, or the pixel has no size.
    """
    require_same_part(statistics, part)
    pixel_size = None if pixel is None else arrays.number_or_nan(pixel)
    if pixel_size is not None and not 0.0 < pixel_size < math.inf:
        raise errors.RequestError(
            "a pixel larger than 0 m",
            f"{pixel!r}",
            "divide the width of the picture on the plate by its pixels",
        )
    groups: dict[int, list[StablePose]] = {}
    for pose in statistics.poses:
        groups.setdefault(pose.group, []).append(pose)
    groups = dict(list(groups.items())[:MOST_GROUPS])
    lookalikes = {group: [group] for group in groups}
    for first, second in _alike_pairs(
        part, [poses[0] for poses in groups.values()], pixel_size
    ):
        lookalikes[first.group].append(second.group)
        lookalikes[second.group].append(first.group)
    indices = {
        group: sorted(pose.index for alike in alikes for pose in groups[alike])
        for group, alikes in lookalikes.items()
    }
    poses = tuple(
        pose.with_values(
            alike_from_above=tuple(
                index for index in indices[pose.group] if index != pose.index
            )
            if pose.group in indices
            else None
        )
        for pose in statistics.poses
    )
    return replace(statistics, poses=poses)


def _alike_pairs(
    part: Part, poses: Sequence[StablePose], pixel: float | None
) -> list[tuple[StablePose, StablePose]]:
    """Pairs of poses, of which the likelier are looked at first, that look alike."""
    silhouettes = [
        (pose, _silhouette(shadow))
        for pose, shadow in zip(poses, outlines.shadows(part, poses), strict=True)
        if not shadow.is_empty()
    ]
    pixel_in_units = None if pixel is None else pixel / outlines.unit_of(part)
    fits_left = MOST_FITTED
    pairs = []
    for (first_pose, first), (second_pose, second) in combinations(silhouettes, 2):
        open_area = _open_area(first, second, pixel_in_units)
        if abs(first.area - second.area) > open_area:
            continue
        comparison = Comparison(first, second, open_area)
        yaws = comparison.best_yaws()
        are_alike = comparison.differs_less(yaws)
        if yaws and not are_alike and fits_left:
            fits_left -= 1
            are_alike = comparison.fits(yaws)
        if are_alike:
            pairs.append((first_pose, second_pose))
    return pairs


def _open_area(first: "Silhouette", second: "Silhouette", pixel: float | None) -> float:
    """Area by which two silhouettes may differ that are alike."""
    area = min(first.area, second.area)
    if pixel is None:
        return ALIKE * area
    return max(FINEST * area, 0.5 * pixel * min(first.length, second.length))


class View(NamedTuple):
    """A silhouette as it is seen on rays from its centroid, in rings of one area."""

    spectrum: NDArray[np.complex128]  # (RAYS // 2 + 1, RINGS); over the yaw
    square: float  # its cells, of which one that is covered in part counts squared


@dataclass(frozen=True, eq=False)
class Silhouette:
    """A silhouette about its centroid with its main axis along x."""

    section: "CrossSection"
    begin: Array  # (E, 2); ends of its edges, the inside on their left
    end: Array

    @cached_property
    def area(self) -> float:
        """Without its holes."""
        return 0.5 * float(_crosses(self.begin, self.end).sum())

    @cached_property
    def length(self) -> float:
        """Of its boundary, that of holes included."""
        return float(np.hypot(*(self.end - self.begin).T).sum())

    @cached_property
    def swept_by_turn(self) -> float:
        """Area that its boundary sweeps in a small turn, a radian."""
        edge = self.end - self.begin
        length = np.hypot(*edge.T)
        foot = -(self.begin * edge).sum(axis=1) / np.maximum(length, 1e-300)
        # Over each edge the integral of the distance from the centroid's foot on it.
        integral = 0.5 * (foot * np.abs(foot) + (length - foot) * np.abs(length - foot))
        return float(integral.sum())

    @cached_property
    def swept_by_difference(self) -> float:
        """Area that its boundary sweeps as the centroid moves, for each area of it.

        An area at its edge that another silhouette lacks moves the centroid by that
        share of the way there; both, laid centroid on centroid, differ by so much more.
        """
        extent_x, extent_y = np.abs(self.begin).max(axis=0)
        run, rise = np.abs(self.end - self.begin).sum(axis=0)
        return float((extent_x * rise + extent_y * run) / self.area)

    @cached_property
    def reach(self) -> float:
        """Of the point farthest from the centroid."""
        return float(np.hypot(*self.begin.T).max())

    @cached_property
    def view(self) -> View:
        """What rays show of it.

        Each edge covers the way from the centroid to itself, or takes it away again if
        it goes round clockwise.
        """
        sweep = np.arctan2(
            _crosses(self.begin, self.end), (self.begin * self.end).sum(axis=1)
        )
        ray_step = 2.0 * np.pi / RAYS
        begin_ray = np.arctan2(self.begin[:, 1], self.begin[:, 0]) / ray_step - 0.5
        end_ray = begin_ray + sweep / ray_step
        first_ray = np.ceil(np.minimum(begin_ray, end_ray)).astype(np.int64)
        ray_count = np.ceil(np.maximum(begin_ray, end_ray)).astype(np.int64) - first_ray
        edge = np.repeat(np.arange(ray_count.size), ray_count)
        number = np.arange(edge.size) - np.repeat(
            ray_count.cumsum() - ray_count, ray_count
        )
        ray = first_ray[edge] + number
        angle = (ray + 0.5) * ray_step
        direction = np.stack((np.cos(angle), np.sin(angle)), axis=1)
        begin = self.begin[edge]
        end = self.end[edge]
        distance = _crosses(begin, end) / _crosses(direction, end - begin)
        ring = RINGS * (distance / REACH) ** 2
        covered = np.clip(ring[:, None] - np.arange(RINGS), 0.0, 1.0)
        cover = np.zeros((RAYS, RINGS))
        np.add.at(cover, ray % RAYS, covered * np.sign(sweep)[edge, None])
        return View(np.fft.rfft(cover, axis=0), float((cover**2).sum()))


def _crosses(first: Array, second: Array) -> Array:
    """Vector products (n,) of vectors in the plane (n, 2)."""
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


def _edges(section: "CrossSection") -> tuple[Array, Array]:
    """Where the edges of an outline begin and end, each (E, 2)."""
    rings = [np.asarray(ring, np.float64) for ring in section.to_polygons()]
    return (
        np.concatenate(rings),
        np.concatenate([np.roll(ring, -1, axis=0) for ring in rings]),
    )


def _silhouette(section: "CrossSection") -> Silhouette:
    """Move an outline to its centroid, and turn its main axis into x."""
    begin, end = _edges(section)
    cross = _crosses(begin, end)
    centroid = cross @ (begin + end) / (3.0 * cross.sum())
    begin = begin - centroid
    end = end - centroid
    cross = _crosses(begin, end)
    moments = np.einsum("e,ei,ej->ij", cross, begin, begin)
    moments += np.einsum("e,ei,ej->ij", cross, end, end)
    moments += np.einsum("e,ei,ej->ij", cross, begin + end, begin + end)
    turn = 0.5 * math.atan2(2.0 * moments[0, 1], moments[0, 0] - moments[1, 1])
    centred = section.translate(tuple(-centroid)).rotate(-math.degrees(turn))
    whole = Silhouette(centred, *_edges(centred))
    outline = centred.simplify(CHORD * whole.area / whole.length)
    return Silhouette(outline, *_edges(outline))


@dataclass(frozen=True, eq=False)
class Comparison:
    """Two silhouettes, one laid on the other."""

    first: Silhouette
    second: Silhouette
    open_area: float  # that they may differ by

    def differing_area(self, motion: Sequence[float]) -> float:
        """After a turn of the second one, radians, and a way in x and y."""
        turned = self.second.section.rotate(math.degrees(motion[0]))
        common = self.first.section ^ turned.translate((motion[1], motion[2]))
        return self.first.area + self.second.area - 2.0 * float(common.area())

    def best_yaws(self) -> list[float]:
        """Turns in which they may differ by no more than is open, the best first.

        On rays and centroid on centroid they differ by more than at best: by what their
        boundaries sweep for that, and up to half a step for each that is seen on rays
        alone, and for the yaw.
        """
        swept_by_turn = max(self.first.swept_by_turn, self.second.swept_by_turn)
        swept = max(self.first.swept_by_difference, self.second.swept_by_difference)
        limit = (1.0 + swept) * self.open_area + 3.0 * np.pi / RAYS * swept_by_turn
        first = self.first.view
        second = self.second.view
        spectrum = (first.spectrum * np.conj(second.spectrum)).sum(axis=1)
        common = np.fft.irfft(spectrum, RAYS)
        difference = CELL * (first.square + second.square - 2.0 * common)
        is_least = (difference <= np.roll(difference, 1)) & (
            difference <= np.roll(difference, -1)
        )
        rays = np.flatnonzero(is_least & (difference <= limit))
        best_rays = rays[np.argsort(difference[rays], kind="stable")][:MOST_YAWS]
        return [ray * 2.0 * np.pi / RAYS for ray in best_rays.tolist()]

    def differs_less(self, yaws: Sequence[float]) -> bool:
        """Whether they differ by no more than is open, centroid on centroid."""
        return any(
            self.differing_area((yaw, 0.0, 0.0)) <= self.open_area for yaw in yaws
        )

    def fits(self, yaws: Sequence[float]) -> bool:
        """The same where the second one is moved and turned as well as can be."""
        from scipy.optimize import minimize  # slow to load, and few pairs need it

        best_yaws = sorted(yaws, key=lambda yaw: self.differing_area((yaw, 0.0, 0.0)))
        way = self.open_area / self.first.area * self.first.reach
        steps = np.vstack((np.zeros(3), np.diag((2.0 * np.pi / RAYS, way, way))))
        for yaw in best_yaws[:MOST_FITTED_YAWS]:
            simplex = steps + np.array((yaw, 0.0, 0.0))
            best = minimize(
                self.differing_area,
                simplex[0],
                method="Nelder-Mead",
                options={
                    "initial_simplex": simplex,
                    "fatol": FITTED * self.open_area,
                    "xatol": math.inf,
                },
            )
            if best.fun <= self.open_area:
                return True
        return False
