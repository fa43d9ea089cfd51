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

"""Which shells are bodies, which are voids, and which have to be turned inside out.

Shells that do not cut each other form a forest: the parent of a shell is the smallest
one around it. Outside of everything and inside a void there is nothing, inside a body
there is metal. A shell wound inward encloses nothing; that makes sense in metal only.
Where it lies in nothing it was exported inverted and is turned, and from there on down
the windings tell nothing: the shells in it are voids and bodies in turn.
"""

from typing import NamedTuple

import numpy as np

from ..kernels.mesh.measures import tetrahedra
from ..records import Array, Index, Mask
from ..tolerances import OVERLAP
from .bodies.overlap import check_patience, reach_into_each_other
from .winding import (
    Shells,
    find_crossings,
    passages_through,
    widths_seen_from_above,
)

# Rounding of a sum of volumes of order one; a folded sheet encloses no more.
_NO_VOLUME = 1e-14

_FEW = 4  # candidates that are asked at first


class Material(NamedTuple):
    """What shells bound."""

    triangles: Index  # (T, 3); normals point out of it
    # share of the volume that counts twice where bodies reach into each other by more
    # than `OVERLAP` of the size, else 0
    doubled_share: float
    body: Index | None = None  # (T,); of each triangle; None for one body


def orient_outward(points: Array, shells: Shells) -> Material:
    """Turn shells of points of size one so that normals point out of the material."""
    weights = tetrahedra(points, shells.triangles)
    if shells.shell_count == 1:
        is_inverted = float(weights.sum()) < 0.0
        return Material(
            np.ascontiguousarray(shells.triangles[:, :: -1 if is_inverted else 1]), 0.0
        )
    volumes = np.bincount(
        shells.shell, weights=weights, minlength=shells.shell_count
    ).astype(np.float64)
    rank = np.argsort(np.argsort(-np.abs(volumes), kind="stable"))
    order = np.argsort(rank[shells.shell], kind="stable")
    shells_by_size = shells._replace(
        triangles=shells.triangles[order], shell=rank[shells.shell][order]
    )
    volumes = volumes[np.argsort(rank)]
    is_outward, owner, is_doubled = _nest_shells(points, shells_by_size, volumes)
    is_turned = (is_outward != (volumes > 0.0))[shells_by_size.shell]
    triangles = np.empty_like(shells_by_size.triangles)
    triangles[order] = np.where(
        is_turned[:, None], shells_by_size.triangles[:, ::-1], shells_by_size.triangles
    )
    body_by_size = owner[shells_by_size.shell]
    body = np.empty_like(body_by_size)
    body[order] = body_by_size
    if not is_doubled and not reach_into_each_other(
        points, shells_by_size.triangles, body_by_size
    ):
        return Material(triangles, 0.0, body)
    return Material(triangles, _doubled_share(points, triangles, body), body)


def _doubled_share(points: Array, triangles: Index, body: Index) -> float:
    """Share of the volume of all bodies beyond that of their union.

    1 where none is known.
    """
    # Only bodies that overlap need it.
    from manifold3d import Error, Manifold, Mesh64, OpType

    solids = [
        Manifold(Mesh64(points, triangles[body == number].astype(np.uint64)))
        for number in np.unique(body)
    ]
    volume = sum(solid.volume() for solid in solids)
    union = Manifold.batch_boolean(solids, OpType.Add)
    return 1.0 - union.volume() / volume if union.status() == Error.NoError else 1.0


def _nest_shells(
    points: Array, shells: Shells, volumes: Array
) -> tuple[Mask, Index, bool]:
    """Apply the rules of the module's docstring to shells (S,) by falling volume.

    Whether each has to bound material from outside; number of its body, of a void that
    of the body around it; whether one body lies in the metal of another.
    """
    parent = _find_parents(points, shells, volumes)
    is_outward = volumes > 0.0
    body = np.arange(shells.shell_count)
    is_untold = np.zeros(shells.shell_count, dtype=bool)
    is_doubled = False
    for shell, outer_shell in enumerate(parent.tolist()):
        if abs(volumes[shell]) <= _NO_VOLUME:
            body[shell] = 0  # a loose flap is nobody's second body
            continue
        in_metal = outer_shell >= 0 and is_outward[outer_shell]
        if outer_shell >= 0 and is_untold[outer_shell]:
            is_outward[shell] = not in_metal
            is_untold[shell] = True
        elif not in_metal and not is_outward[shell]:
            is_outward[shell] = is_untold[shell] = True
        is_doubled |= bool(in_metal and is_outward[shell])
        if not is_outward[shell]:
            body[shell] = body[outer_shell]
    return is_outward, body, is_doubled


def _find_parents(points: Array, shells: Shells, volumes: Array) -> Index:
    """Find the smallest shell around each (S,), -1 for none.

    Shells by falling volume.
    """
    corners = points[shells.triangles]
    shell_start = np.searchsorted(shells.shell, np.arange(shells.shell_count + 1))
    low = np.minimum.reduceat(corners.min(axis=1), shell_start[:-1])
    high = np.maximum.reduceat(corners.max(axis=1), shell_start[:-1])
    parent = np.full(shells.shell_count, -1)
    for shell in range(1, shells.shell_count):
        check_patience()
        if abs(volumes[shell]) <= _NO_VOLUME:
            break
        candidates = np.flatnonzero(
            (low[:shell] <= low[shell] + OVERLAP).all(axis=1)
            & (high[:shell] >= high[shell] - OVERLAP).all(axis=1)
        )
        if len(candidates) == 0:
            continue
        shell_triangles = slice(int(shell_start[shell]), int(shell_start[shell + 1]))
        point = _find_inner_point(points, shells.triangles[shell_triangles])
        if point is None:
            continue
        parent[shell] = _find_smallest_around(
            points, shells, shell_start, candidates, point
        )
    return parent


def _find_smallest_around(
    points: Array, shells: Shells, shell_start: Index, candidates: Index, point: Array
) -> int:
    """Find the last of the candidates (rising) that encloses a point, -1 for none.

    It tends to be among the smallest: a few of these are asked first.
    """
    batch = _FEW
    while len(candidates):
        candidates, chosen_shells = candidates[:-batch], candidates[-batch:]
        rows = np.concatenate(
            [np.arange(shell_start[k], shell_start[k + 1]) for k in chosen_shells]
        )
        x, y, z = point.tolist()
        crossed, height, sign = find_crossings(points, shells.triangles[rows], x, y)
        is_above = height > z
        enclosing_shells = np.flatnonzero(
            np.bincount(shells.shell[rows[crossed[is_above]]], weights=sign[is_above])
        )
        if len(enclosing_shells):
            return int(enclosing_shells.max())
        batch *= 4
    return -1


def _find_inner_point(points: Array, triangles: Index) -> Array | None:
    """Find a point well inside a shell: the middle of its widest vertical passage."""
    widest_triangle = triangles[widths_seen_from_above(points, triangles).argmax()]
    x, y, height, winding = passages_through(points, triangles, widest_triangle)
    passage = np.diff(height) * (winding != 0)
    if passage.max(initial=0.0) <= 0.0:
        return None
    longest_passage = int(passage.argmax())
    return np.array([x, y, height[longest_passage] + 0.5 * passage[longest_passage]])
