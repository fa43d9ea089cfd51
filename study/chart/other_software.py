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

"""Other software on the chart: `trimesh.poses`."""

from collections.abc import Iterator, Sequence
from functools import partial
from statistics import median

import numpy as np
import trimesh
from scipy.spatial import cKDTree
from trimesh.poses import compute_stable_poses

from lab.frame.timing import timed
from ros_pose_stats.core.records import Array
from ros_pose_stats.core.resting.poses import RestingPoses

from ..errors.partition import accuracy
from ..errors.simulated_poses import pooled
from ..figures.speed_accuracy import ChartPoint
from .bodies import Size
from .methods import measured_point

SAME_FACE = 1e-3
SAME_FACET = 0.2
"""Angle within which a pose of trimesh is one of our faces, radians; on a round
surface, which has other facets here than in the file.
"""


def trimesh_points(size: Size) -> Iterator[ChartPoint]:
    """`trimesh.poses.compute_stable_poses` without sampling the centre of mass.

    Timed on a new `Trimesh` of the same arrays, whose construction does not count.
    """
    probabilities = []
    seconds = []
    for mesh, resting in zip(size.meshes, size.restings, strict=True):
        body = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
        answer, took = timed(
            partial(compute_stable_poses, body, center_mass=mesh.center_of_mass)
        )
        seconds.append(took)
        probabilities.append(match_poses(resting, *answer))
    simulated = pooled(list(size.simulated.values()))
    error = accuracy(
        np.tile(np.concatenate(probabilities), len(size.simulated)), simulated
    )
    yield measured_point("trimesh.poses", "outside", median(seconds), error)


def match_poses(
    resting: RestingPoses, transforms: Array, probabilities: Sequence[float]
) -> Array:
    """Another program's probabilities in the order of our poses, without those that
    match none.
    """
    theirs = -np.asarray(transforms)[:, 2, :3]
    gap, face = cKDTree(resting.equilibria.downs).query(theirs)
    is_match = gap < (SAME_FACET if resting.body.rounded else SAME_FACE)
    return np.bincount(
        resting.clusters.pose[face[is_match]],
        np.asarray(probabilities)[is_match],
        len(resting.poses),
    ).astype(np.float64)
