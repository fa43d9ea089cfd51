"""Other software on the chart: `trimesh.poses`, and MuJoCo where it is installed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from statistics import median

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from trimesh.poses import compute_stable_poses

from lab.frame.timing import timed
from ros_pose_stats.core.resting.poses import RestingPoses

from ..errors.partition import accuracy
from ..errors.simulated_poses import pooled
from ..figures.speed_accuracy import ChartPoint
from ..mujoco_drops import Plate, available, drop_in_mujoco, fit_contact
from .bodies import Size
from .methods import measured_point

Array = NDArray[np.float64]

SAME_FACE = 1e-3
SAME_FACET = 0.2
"""Angle within which a pose of trimesh is one of our faces, radians; on a round
surface, which has other facets here than in the file.
"""

MUJOCO_DROPS = (10, 100)
MUJOCO_DEPTH = 0.01
MUJOCO_STEPS = 10
"""Median depth of first impacts in radii, and time steps a contact, of a good
setting.
"""

MUJOCO_RESTITUTIONS = 0.1, 0.9
"""Lowest and highest restitution that such contacts are set to."""


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


def mujoco_points(
    size: Size, say: Callable[[str], object] = lambda _: None
) -> Iterator[ChartPoint]:
    """Drops by MuJoCo from 20 radii; only the time inside `mj_step` counts.

    The error comes from both MuJoCo's noise and its different contacts. There is no
    point where it is not installed or cannot simulate the scene; `say` is called with
    the reason.
    """
    low, high = MUJOCO_RESTITUTIONS
    if not available():
        say("MuJoCo is not installed, left out")
        return
    if not low <= min(size.simulated) <= max(size.simulated) <= high:
        say(
            "MuJoCo is left out: its contacts reach restitutions from "
            f"{low:g} to {high:g}"
        )
        return
    try:
        seconds, shares = _mujoco_shares(size)
    except RuntimeError as error:
        say(f"MuJoCo is left out: {error}")
        return
    simulated = pooled(list(size.simulated.values()))
    for drops, values in shares.items():
        yield measured_point(
            f"n = {drops}",
            "outside",
            drops * seconds,
            accuracy(values, simulated),
            "MuJoCo",
        )


def _mujoco_shares(size: Size) -> tuple[float, dict[int, Array]]:
    """Median seconds of a drop; shares of the poses after some drops, as `pooled` has
    them.
    """
    shares: dict[int, list[Array]] = {drops: [] for drops in MUJOCO_DROPS}
    seconds: list[float] = []
    for restitution in size.simulated:
        for number, mesh in enumerate(size.meshes):
            plate = Plate(mesh.part(), 0.0)
            most = max(MUJOCO_DROPS)
            contact = fit_contact(plate, restitution, MUJOCO_DEPTH, MUJOCO_STEPS)
            duration, index = drop_in_mujoco(plate, contact, most, number)
            seconds.append(duration / most)
            for drops, shares_of in shares.items():
                counts = np.bincount(
                    index[:drops], minlength=len(size.restings[number].poses)
                )
                shares_of.append(counts / drops)
    return median(seconds), {
        drops: np.concatenate(columns) for drops, columns in shares.items()
    }


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
