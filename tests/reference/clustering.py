"""Poses by persistence, read word for word from the contract, with no tree and no union-find.

From each stable face the lowest ways are flooded until a lower face is met: the highest saddle on
the way is where the face ends. If that is no share of its height above it, the face belongs to
the pose across that saddle.
"""

from __future__ import annotations

import heapq
from collections import defaultdict

import numpy as np


def saddles_of(resting):
    """Neighbours of each stable face: lists of (level in radii, neighbour)."""
    found = resting.equilibria
    basin = found.rank[found.arrays.basin]
    ways = defaultdict(list)
    for ends, faces in zip(*resting.body.edges, strict=True):
        one, other = (int(basin[face]) for face in faces)
        if one != other:
            level = _distance(*resting.body.points[ends])
            level = max(level, *resting.body.arrays.distance[faces])
            ways[one].append((level, other))
            ways[other].append((level, one))
    return ways


def _distance(first, last):
    along = last - first
    share = np.clip(-(first @ along) / (along @ along), 0.0, 1.0)
    return float(np.linalg.norm(first + share * along))


def persistent_poses(resting, tolerance):
    """Poses as sets of stable faces, with the level of the lowest saddle out of each.

    Parameters
    ----------
    resting : RestingPoses
        At any tolerance.
    tolerance : float
        Share of the height.

    Returns
    -------
    dict
        frozenset of stable faces -> level in radii; infinite for a single pose.
    """
    ways, heights = saddles_of(resting), resting.equilibria.heights
    areas = resting.body.arrays.area[resting.equilibria.faces]
    onward = {}

    def rank(face):
        """What stands for a pose: the lowest, then the largest face, then the first."""
        return round(heights[face], 9), -round(areas[face], 9), face

    for face in range(len(heights)):
        level, across = _flood(ways, rank, face)
        if level - heights[face] < tolerance * heights[face]:
            onward[face] = across
    poses = defaultdict(set)
    for face in range(len(heights)):
        end = face
        while end in onward:
            end = onward[end]
        poses[end].add(face)
    return {frozenset(members): min(
        (level for face in members for level, other in ways[face] if other not in members),
        default=np.inf) for members in poses.values()}


def _flood(ways, rank, start):
    """Level at which a flood from a face meets a lower one, and the face across that saddle."""
    flooded, level, across = {start}, -np.inf, None
    waiting = list(ways[start])
    heapq.heapify(waiting)
    while waiting:
        here, face = heapq.heappop(waiting)
        if face in flooded:
            continue
        if here > level:  # the saddle that holds all that comes after it
            level, across = here, face
        if rank(face) < rank(start):
            return level, across
        flooded.add(face)
        for way in ways[face]:
            heapq.heappush(waiting, way)
    return np.inf, None
