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

"""From a part to its pose statistics by an estimator."""

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from importlib import import_module

import numpy as np

from ...base import errors, methods
from ..records import Array, DropScene, Part, PoseStatistics
from ..records.notes import Note, note
from ..records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
    LOW_DROP_RADII,
)
from ..records.shares import pose_statistics
from ..resting import poses, trust
from . import published
from .expected import ExpectedError, best_method, expected_errors, unknown_error


@dataclass(frozen=True)
class Estimator(methods.Method):
    """A method with its function."""

    # from `RestingPoses` and `DropScene` to probabilities (P,), in the order of
    # `index`, summing to 1
    function: Callable[[poses.RestingPoses, DropScene], Array] = field(kw_only=True)


def bind_function(method: methods.Method) -> Estimator:
    """Join a row of `methods` and its function, which then takes poses and scene.

    Where faces tie, as the two of a coin do for its rim, an estimator decides for one
    of them; so poses that symmetry makes equal share their probability.
    """
    function = getattr(import_module(f".{method.module}", __package__), method.name)

    def evened(resting: poses.RestingPoses, scene: DropScene) -> Array:
        return published.share_in_groups(
            function(resting, scene) if method.knows_scene else function(resting),
            resting.group,
        )

    return Estimator(**vars(method), function=evened)


ESTIMATORS = {
    method.name: bind_function(method) for method in methods.METHODS if method.module
}


def estimator(name: str) -> Estimator:
    """Look an estimator up."""
    try:
        return ESTIMATORS[name]
    except (KeyError, TypeError):
        raise errors.RequestError(
            f"a method out of {', '.join(methods.AT_ONCE)}",
            f"{name!r}",
            "see `ros_pose_stats estimate --help`",
        ) from None


def estimate_in(
    part: Part, scene: DropScene, method: str = methods.AUTO
) -> PoseStatistics:
    """Estimate without drops, by a name, or `auto` for the one that errs least."""
    name = best_method(scene.restitution) if method == methods.AUTO else method
    return estimates_in(part, scene, [name])[0]


def estimates_in(
    part: Part, scene: DropScene, names: Iterable[str] = ESTIMATORS
) -> list[PoseStatistics]:
    """Estimate without drops by several methods, which share the work and its time."""
    begin = time.perf_counter()
    chosen = [estimator(name) for name in names]
    resting = poses.poses_in(part, scene)
    probabilities = np.array([entry.function(resting, scene) for entry in chosen])
    if part.error_known:
        expectations = expected_errors(
            [entry.name for entry in chosen], resting, probabilities, scene
        )
    else:
        expectations = list(map(unknown_error, probabilities))
    notes = trust.pose_notes(resting)
    seconds = (time.perf_counter() - begin) / len(chosen)
    return [
        pose_statistics(
            part,
            resting.body.radius,
            resting.poses,
            expected.shares(probability),
            entry.name,
            scene,
            knows_scene=entry.knows_scene,
            seconds=seconds,
            warnings=(*notes, *_warnings(resting, entry, scene, expected)),
        )
        for entry, probability, expected in zip(
            chosen, probabilities, expectations, strict=True
        )
    ]


def estimate_all(
    part: Part,
    *,
    restitution: float = DEFAULT_RESTITUTION,
    drop_height: float | None = None,
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
    round_sides: int = DEFAULT_ROUND_SIDES,
) -> list[PoseStatistics]:
    """Estimate by every registered method, in the registry's order, without drops.

    Parameters and errors are those of `estimate`. What methods have in common is done
    once, and `seconds` of each answer is the same share of the time of all.
    """
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    return estimates_in(part, scene)


def _warnings(
    resting: poses.RestingPoses,
    chosen: Estimator,
    scene: DropScene,
    expected: ExpectedError,
) -> list[Note]:
    warnings = []
    radii = math.inf
    if scene.drop_height is not None:
        radii = scene.drop_height / resting.body.radius
    points = f"{100.0 * expected.part_error:.2g} points"
    if radii < LOW_DROP_RADII and not chosen.knows_scene:
        warnings.append(
            note(
                "LOW_DROP",
                f"released {radii:.2g} radii above the plate, but {chosen.name} does "
                "not know the drop height; expect the pose at release to be more "
                "frequent.",
            )
        )
    if expected.is_unmeasured:
        warnings.append(
            note(
                "OUTSIDE_FIT",
                f"part or scene lie outside of those that {chosen.name} was measured "
                f"on; its error may well be larger than the {points} expected, so "
                "simulate it.",
            )
        )
    if expected.is_unusual:
        warnings.append(
            note(
                "METHODS_DISAGREE",
                "eae, meae and qse differ by up to "
                f"{100.0 * expected.disagreement:.2g} points on this part; expect an "
                f"error of {points} where {chosen.name} usually has "
                f"{100.0 * expected.usual_error:.2g}, or simulate it.",
            )
        )
    return warnings
