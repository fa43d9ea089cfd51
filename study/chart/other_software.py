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

from ros_pose_stats.core.resting.poses import RestingPoses

from ..errors.partition import accuracy
from ..errors.simulated_poses import SimulatedPoses, pooled
from ..figures.speed_accuracy import ChartPoint
from ..mujoco_drops import Plate, available, drop_in_mujoco, fit_contact
from .bodies import Size
from .methods import point, timed

Array = NDArray[np.float64]

SAME_FACE = 1e-3
SAME_FACET = 0.2
"""Angle within which a pose of trimesh is one of our faces, radians; on a round surface, which has
other facets here than in the file."""

MUJOCO_DROPS = (10, 100)
MUJOCO_DEPTH = 0.01
MUJOCO_STEPS = 10
"""Median depth of first impacts in radii, and time steps a contact, of a good setting."""

MUJOCO_RESTITUTIONS = 0.1, 0.9
"""Lowest and highest restitution that such contacts are set to."""


def trimesh_points(size: Size, parts: int) -> Iterator[ChartPoint]:
    """`trimesh.poses.compute_stable_poses` without sampling the centre of mass.

    Timed on a new `Trimesh` of the same arrays, whose construction does not count.
    """
    chosen = _first(size, parts)
    probabilities = []
    seconds = []
    for mesh, known in zip(size.meshes[:chosen], size.known, strict=False):
        body = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
        took, found = timed(
            partial(compute_stable_poses, body, center_mass=mesh.center_of_mass)
        )
        seconds.append(took)
        probabilities.append(matched(known, *found))
    every = pooled([_of_first(one, chosen) for one in size.simulated.values()])
    error = accuracy(np.tile(np.concatenate(probabilities), len(size.simulated)), every)
    yield point("trimesh.poses", "outside", median(seconds), error)


def mujoco_points(
    size: Size, parts: int, say: Callable[[str], object] = lambda _: None
) -> Iterator[ChartPoint]:
    """Drops by MuJoCo from 20 radii; only the time inside `mj_step` counts.

    The error comes from both MuJoCo's noise and its different contacts. There is no point where
    it is not installed or cannot simulate the scene; `say` is called with the reason.
    """
    low, high = MUJOCO_RESTITUTIONS
    if not available():
        say("MuJoCo is not installed, left out")
        return
    if not low <= min(size.simulated) <= max(size.simulated) <= high:
        say(
            f"MuJoCo is left out: its contacts reach restitutions from {low:g} to {high:g}"
        )
        return
    chosen = _first(size, parts)
    try:
        seconds, shares = _mujoco_shares(size, chosen)
    except RuntimeError as error:
        say(f"MuJoCo is left out: {error}")
        return
    every = pooled([_of_first(one, chosen) for one in size.simulated.values()])
    for drops, values in shares.items():
        yield point(
            f"n = {drops}",
            "outside",
            drops * seconds,
            accuracy(values, every),
            "MuJoCo",
        )


def _mujoco_shares(size: Size, bodies: int) -> tuple[float, dict[int, Array]]:
    """Median seconds of a drop; shares of the poses after some drops, as `pooled` has them."""
    shares: dict[int, list[Array]] = {drops: [] for drops in MUJOCO_DROPS}
    seconds: list[float] = []
    for restitution in size.simulated:
        for number, mesh in enumerate(size.meshes[:bodies]):
            plate = Plate(mesh.part(), 0.0)
            most = max(MUJOCO_DROPS)
            contact = fit_contact(plate, restitution, MUJOCO_DEPTH, MUJOCO_STEPS)
            duration, index = drop_in_mujoco(plate, contact, most, number)
            seconds.append(duration / most)
            for drops, shares_of in shares.items():
                seen = np.bincount(
                    index[:drops], minlength=len(size.known[number].poses)
                )
                shares_of.append(seen / drops)
    return median(seconds), {
        drops: np.concatenate(one) for drops, one in shares.items()
    }


def matched(
    known: RestingPoses, transforms: Array, probabilities: Sequence[float]
) -> Array:
    """Another program's probabilities in the order of our poses, without those that match none."""
    theirs = -np.asarray(transforms)[:, 2, :3]
    gap, face = cKDTree(known.equilibria.downs).query(theirs)
    near = gap < (SAME_FACET if known.body.rounded else SAME_FACE)
    return np.bincount(
        known.clusters.pose[face[near]],
        np.asarray(probabilities)[near],
        len(known.poses),
    ).astype(np.float64)


def _first(size: Size, parts: int) -> int:
    return min(parts, len(size.meshes))


def _of_first(simulated: SimulatedPoses, bodies: int) -> SimulatedPoses:
    """Of the first bodies alone."""
    kept = simulated.body < bodies
    return SimulatedPoses(
        simulated.body[kept], simulated.count[kept], simulated.settled[kept]
    )
