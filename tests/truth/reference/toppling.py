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

"""Stability and quasi-static toppling from a list of hull points, in plain loops.

Faces are polygons; an unstable one topples over the edge that the segment from its
centroid to the foot of the centre of mass leaves through (section 4.B). Written for
clarity, without regard to ties: the bodies compared with it have none.
"""

from itertools import pairwise

import numpy as np
from scipy.spatial import ConvexHull, cKDTree


def distinct(rows, within=1e-7):
    """Indices of rows that no earlier one is as close to: a hull repeats a plane by
    triangles.
    """
    neighbours = cKDTree(rows).query_ball_point(rows, within)
    return [row for row, others in enumerate(neighbours) if min(others) == row]


def solid_angle(a, b, c):
    """Of a triangle seen from the origin (Van Oosterom and Strackee), in extended
    precision.
    """
    a, b, c = (np.asarray(x, dtype=np.longdouble) for x in (a, b, c))
    a, b, c = (x / np.sqrt((x * x).sum()) for x in (a, b, c))
    triple = abs(np.dot(a, np.cross(b, c)))
    return 2.0 * np.arctan2(triple, 1.0 + np.dot(a, b) + np.dot(b, c) + np.dot(c, a))


class Polyhedron:
    """Faces of a hull about its centre of mass: normal, corners in order, foot."""

    def __init__(self, vertices, center_of_mass):
        points = np.asarray(vertices, dtype=float) - center_of_mass
        hull = ConvexHull(points)
        self.normals = []
        self.corners = []
        for plane in hull.equations[distinct(hull.equations)]:
            normal = plane[:3]
            corners_on = np.flatnonzero(
                np.abs(points @ normal + plane[3]) < 1e-9 * np.abs(points).max()
            )
            spokes = points[corners_on] - points[corners_on].mean(axis=0)
            across = np.cross(normal, spokes[0])
            angle = np.arctan2(spokes @ across, spokes @ spokes[0])
            self.normals.append(normal)
            self.corners.append(corners_on[np.argsort(angle)].tolist())
        self.points = points
        self.normals = np.array(self.normals)

    def polygon(self, face):
        return self.points[self.corners[face]]

    def distance(self, face):
        return float(self.polygon(face)[0] @ self.normals[face])

    def angle(self, face):
        first, *rest = self.polygon(face)
        return float(sum(solid_angle(first, b, c) for b, c in pairwise(rest)))

    def area_vector(self, face):
        """Area along the normal, and the centroid."""
        first, *rest = self.polygon(face)
        parts = [
            (
                0.5 * np.linalg.norm(np.cross(b - first, c - first)),
                (first + b + c) / 3.0,
            )
            for b, c in pairwise(rest)
        ]
        area = sum(size for size, _ in parts)
        return area, sum(size * centroid for size, centroid in parts) / area

    def insets(self, face, point):
        """Distance of a point of the face's plane from each edge, positive inside."""
        corners = self.polygon(face)
        along = np.roll(corners, -1, axis=0) - corners
        inward = np.cross(self.normals[face], along)
        return ((point - corners) * inward).sum(axis=1) / np.linalg.norm(inward, axis=1)

    def neighbour(self, face, edge):
        """The other face with both ends of an edge."""
        loop = self.corners[face]
        ends = {loop[edge], loop[(edge + 1) % len(loop)]}
        return next(
            candidate
            for candidate, corners in enumerate(self.corners)
            if candidate != face and ends <= set(corners)
        )

    def topples_to(self, face):
        """The face that an unstable one topples onto; itself when it is stable."""
        foot = self.distance(face) * self.normals[face]
        at_foot = self.insets(face, foot)
        if at_foot.min() > 0.0:
            return face
        at_centroid = self.insets(face, self.area_vector(face)[1])
        leaves = np.where(at_foot < 0.0, at_centroid / (at_centroid - at_foot), np.inf)
        return self.neighbour(face, int(leaves.argmin()))

    def quasi_static(self):
        """Probability of each face after toppling."""
        result = np.zeros(len(self.corners))
        for face in range(len(self.corners)):
            end = face
            while self.topples_to(end) != end:
                end = self.topples_to(end)
            result[end] += self.angle(face) / (4.0 * np.pi)
        return result
