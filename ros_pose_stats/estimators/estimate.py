"""From a part to its pose statistics by an estimator."""

import math
import time
from dataclasses import replace

from ..methods import AUTO
from ..records import DropScene, Part, PoseStatistics, scene as scenes, statistics
from ..resting import poses, trust
from .expected import ExpectedError, best_method, expected_error, explain_best
from .registry import ESTIMATORS, Estimator, estimator


def estimate_in(part: Part, scene: DropScene, method: str = AUTO) -> PoseStatistics:
    """Estimate by an estimator's name, or `auto` for the one that errs least, without drops."""
    begin = time.perf_counter()
    chosen = estimator(best_method(scene.restitution) if method == AUTO else method)
    resting = poses.poses_in(part, scene)
    remarks = trust.pose_remarks(resting)
    probability = chosen.function(resting, scene)
    expected = expected_error(chosen.name, resting, probability, scene)
    found = statistics.pose_statistics(
        part, resting.body.radius, resting.poses, expected.shares(probability), chosen.name, scene,
        knows_scene=chosen.knows_scene, seconds=time.perf_counter() - begin,
        warnings=(*remarks.warnings, *_warnings(resting, chosen, scene, expected)),
        notes=remarks.notes)
    return replace(found, choice=explain_best(chosen.name)) if method == AUTO else found


def estimate_all(part: Part, *, restitution: float = scenes.DEFAULT_RESTITUTION,
                 drop_height: float | None = None,
                 cluster_tolerance: float = scenes.DEFAULT_CLUSTER_TOLERANCE,
                 round_sides: int = scenes.DEFAULT_ROUND_SIDES) -> list[PoseStatistics]:
    """Estimate by every registered method, in the registry's order, without drops.

    Parameters and errors are those of `estimate`.
    """
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    return [estimate_in(part, scene, name) for name in ESTIMATORS]


def _warnings(resting: poses.RestingPoses, chosen: Estimator, scene: DropScene,
              expected: ExpectedError) -> list[str]:
    warnings = []
    radii = math.inf if scene.drop_height is None else scene.drop_height / resting.body.radius
    if radii < scenes.LOW_DROP_RADII and not chosen.knows_scene:
        warnings.append(
            f"LOW_DROP: released {radii:.2g} radii above the plate, but {chosen.name} does not "
            f"know the drop height; expect the pose at release to be more frequent.")
    if expected.unknown:
        warnings.append(
            f"OUTSIDE_FIT: part or scene lie outside of those that {chosen.name} was measured on; "
            f"its error may well be larger than the {100.0 * expected.here:.2g} points expected, "
            f"so simulate it.")
    if expected.unusual:
        warnings.append(
            f"METHODS_DISAGREE: eae, meae and qse differ by up to {100.0 * expected.apart:.2g} "
            f"points on this part; expect an error of {100.0 * expected.here:.2g} points where "
            f"{chosen.name} usually has {100.0 * expected.usual:.2g}, or simulate it.")
    return warnings
