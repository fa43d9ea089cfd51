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

"""Whether the bodies that are taken as one rigid part touch each other."""

import numpy as np

from ... import tolerances
from ...records import Array, Index
from .. import vectors, winding
from .overlap import check_patience


def has_loose_bodies(points: Array, triangles: Index, body: Index) -> bool:
    """Whether a gap parts some bodies of size one from all others.

    It counts where it is wider than both chord errors: less than that is how far
    touching curves are apart as polygons. `body` (T,): of each triangle.
    """
    numbers, body = np.unique(body, return_inverse=True)
    if len(numbers) == 1:
        return False
    from manifold3d import Error, Manifold, Mesh64

    order = np.argsort(body, kind="stable")
    start = np.searchsorted(body[order], np.arange(len(numbers) + 1))
    corners = points[triangles[order]]
    low = np.minimum.reduceat(corners.min(axis=1), start[:-1])
    high = np.maximum.reduceat(corners.max(axis=1), start[:-1])
    chord_error = _chord_errors(points, triangles, body) + 0.5 * tolerances.OVERLAP
    solids: dict[int, Manifold] = {}

    def solid(number: int) -> Manifold:
        if number not in solids:
            rows = triangles[order[start[number] : start[number + 1]]]
            used, corner_numbers = np.unique(rows, return_inverse=True)
            corners_of_body = corner_numbers.reshape(-1, 3).astype(np.uint64)
            solids[number] = Manifold(Mesh64(points[used], corners_of_body))
        return solids[number]

    apart = np.arange(1, len(numbers))
    queue = [0]
    while queue and len(apart):
        check_patience()
        number = queue.pop()
        widest_gap = chord_error[number] + chord_error[apart]
        boxes_meet = (low[apart] - high[number] <= widest_gap[:, None]) & (
            low[number] - high[apart] <= widest_gap[:, None]
        )
        touching = []
        for k in np.flatnonzero(boxes_meet.all(axis=1)).tolist():
            pair = solid(number), solid(int(apart[k]))
            # A body that touches itself along an edge is no manifold, and not judged.
            is_judged = all(body.status() == Error.NoError for body in pair)
            gap = pair[0].min_gap(pair[1], float(widest_gap[k])) if is_judged else 0.0
            if gap < widest_gap[k]:
                touching.append(k)
        queue += apart[touching].tolist()
        apart = np.delete(apart, touching)
    return len(apart) > 0


def _chord_errors(points: Array, triangles: Index, body: Index) -> Array:
    """How far the curves of each body may be beyond its facets.

    Of an arc of one facet to either side of an edge, where the bend is none that was
    designed.
    """
    edges = winding.group_edges(triangles)
    is_shared = edges.uses == 2
    directed = edges.edge[edges.start[is_shared]]
    opposite = edges.edge[edges.start[is_shared] + 1]
    triangle = directed // 3
    neighbour = opposite // 3
    corner = directed % 3
    side = points[triangles[triangle, (corner + 1) % 3]]
    side = side - points[triangles[triangle, corner]]
    area = vectors.area_vectors(points, triangles)
    size = vectors.lengths(area)
    normal = area / np.where(size > 0.0, size, 1.0)[:, None]
    cosine = (normal[triangle] * normal[neighbour]).sum(axis=1)
    bend = np.arccos(np.clip(cosine, -1.0, 1.0))
    width = np.minimum(size[triangle], size[neighbour]) / vectors.lengths(side)
    error = np.where(bend < tolerances.BENT, 0.5 * width * np.tan(0.25 * bend), 0.0)
    errors = np.zeros(int(body.max()) + 1)
    np.maximum.at(errors, body[triangle], error)
    return errors
