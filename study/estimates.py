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

"""Estimates of the bodies of a dataset by every estimator, and their errors."""

from collections.abc import Callable

import numpy as np

from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.records import Array, DropScene
from ros_pose_stats.core.resting.poses import RestingPoses

from .dataset import Dataset
from .errors.simulated_poses import SimulatedPoses


def restings(
    dataset: Dataset, on_progress: Callable[[int], object] = lambda _: None
) -> list[RestingPoses]:
    """Stable poses of every body, in the order of the counts.

    Parameters
    ----------
    dataset : Dataset
    on_progress : callable, optional
        Called with the number of bodies done.
    """
    poses = []
    for number in range(
        dataset.spec.bodies
    ):  # threads would wait for the lock and be slower
        poses.append(dataset.resting(number))
        on_progress(number + 1)
    return poses


def estimates(
    poses: list[RestingPoses], scene: DropScene, earlier: dict[str, Array] | None = None
) -> dict[str, Array]:
    """Probabilities (P,) of all bodies' poses in one scene, by the name of the method.

    Parameters
    ----------
    poses : list of RestingPoses
        Of bodies of about the same size: the drop height is in metres.
    scene : DropScene
    known : dict of str to (P,) array, optional
        Estimates for another scene; those of methods that do not know the scene are
        taken over.
    """
    reusable = {} if earlier is None else earlier
    return {
        name: reusable[name]
        if name in reusable and not entry.knows_scene
        else np.concatenate([entry.function(resting, scene) for resting in poses])
        for name, entry in ESTIMATORS.items()
    }


def scene_estimates(
    dataset: Dataset, poses: list[RestingPoses]
) -> dict[float, dict[str, Array]]:
    """Estimates at each restitution of a dataset, as from `estimates`."""
    by_restitution: dict[float, dict[str, Array]] = {}
    earlier = None
    for restitution in dataset.spec.restitutions:
        earlier = estimates(
            poses, DropScene(restitution, dataset.spec.drop_height, 0.0, 0), earlier
        )
        by_restitution[restitution] = earlier
    return by_restitution


def square_errors(values: Array, reference: SimulatedPoses) -> Array:
    """Mean square error (B,) of each body, the reference's noise taken off.

    By chance some are negative.

    Parameters
    ----------
    values : (P,) array
        Probabilities in the order of the reference.
    reference : SimulatedPoses
        Of bodies 0 ... B - 1 at one restitution.
    """
    away = np.square(values - reference.probability) - reference.noise_variance()
    return np.bincount(reference.body, away) / np.bincount(reference.body)
