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

"""A part as it most probably lies: the motion that lays its mesh down."""

import numpy as np

from ..mesh.units import metres_per_unit
from ..mesh.vectors import (
    components_along,
    resting_quaternions,
    rotation_matrices,
    turn_vectors,
)
from ..records import Array, DropScene, Part, PoseStatistics
from ..records.statistics import require_same_part
from ..resting.poses import bare_poses
from .auto import estimate

_MESH_AS_IT_IS = DropScene(cluster_tolerance=0.0, round_sides=0)
"""Scene in which every stable face of the mesh is a pose."""


def upright(
    part: Part, statistics: PoseStatistics | None = None, *, unit: str | float = 1.0
) -> Array:
    """The motion that turns a part into its most probable pose, resting on z = 0.

    The pose is that of the first row of the answer. Where it is on a round surface,
    which answers take as a fine polygon, the mesh is laid on the nearest of its own
    faces that it can rest on. Its lowest point is at z = 0, and the centre of mass is
    above the origin.

    Parameters
    ----------
    part : Part
    statistics : PoseStatistics, optional
        An answer about the part, by any method; default: `estimate(part)`.
    unit : str or float
        Of the translation: `m`, `mm`, `cm`, `inch` or metres a unit, as of the mesh
        that is to be moved, for instance `part.unit`.

    Returns
    -------
    (4, 4) array
        Takes points of the part frame to the plate frame, z up, as
        `trimesh.Trimesh.apply_transform` takes it.

    Raises
    ------
    RequestError
        If `part` is no Part, the statistics are of another part, or `unit` is no unit.
    """
    metres = metres_per_unit(unit)
    if statistics is None:
        statistics = estimate(part)
    require_same_part(statistics, part)
    downs = bare_poses(part, _MESH_AS_IT_IS).downs
    face = int(np.argmax(components_along(downs, statistics.poses[0].down)))
    rotation = rotation_matrices(resting_quaternions(downs[face : face + 1]))[0]
    heights = components_along(part.surface_vertices, rotation[2])
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = -turn_vectors(part.center_of_mass[None], rotation.T)[0] / metres
    matrix[2, 3] = -heights.min() / metres
    return matrix
