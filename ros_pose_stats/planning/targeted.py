"""Keeping a target error: by an estimate that is good enough, else by drops."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from ..methods import HYBRID
from ..records import DropProgress, DropScene, Part, PoseStatistics
from ..resting.poses import resting_poses
from ..simulation.simulate import simulate
from ..statistics.posterior import PosePrior
from ..statistics.prefix import Judge
from .confidence import (
    enough,
    estimate_bound,
    first_look,
    judge_drops,
    not_enough,
    prior_of,
    worthwhile,
)
from .hybrid import combined_progress, hybrid_statistics


class Asked(NamedTuple):
    """What `auto` hands on to the drops."""

    target_error: float
    drops: int
    seed: int | None
    workers: int | None


def keep_target(best: PoseStatistics, part: Part, scene: DropScene, asked: Asked,
                on_progress: Callable[[DropProgress], object] | None,
                should_stop: Callable[[], bool]) -> tuple[PoseStatistics, str]:
    """The estimate if it keeps the target, else drops; and why."""
    prior = prior_of(best, resting_poses(part, scene.cluster_tolerance, scene.round_sides), scene)
    bound = estimate_bound(prior)
    if bound <= asked.target_error:
        return best, enough(f"{best.method} alone", bound, asked.target_error)
    found = _dropped(part, scene, asked, prior, on_progress, should_stop)
    return found, _why_drops(found, best.method, bound, asked.target_error)


def _dropped(part: Part, scene: DropScene, asked: Asked, prior: PosePrior,
             on_progress: Callable[[DropProgress], object] | None,
             should_stop: Callable[[], bool]) -> PoseStatistics:
    """As many drops as the target needs, with the estimate's help where it has some worth."""
    helped = worthwhile(prior, asked.target_error)
    counted = simulate(
        part, asked.drops, scene.restitution, asked.seed, scene.drop_height, asked.target_error,
        asked.workers, should_stop=should_stop, cluster_tolerance=scene.cluster_tolerance,
        round_sides=scene.round_sides,
        on_progress=combined_progress(prior, on_progress) if helped else on_progress,
        judge=Judge(partial(judge_drops, prior if helped else None),
                    first_look(prior, asked.target_error, helped)))
    return hybrid_statistics(counted, prior) if helped else counted


def _why_drops(found: PoseStatistics, method: str, bound: float, target_error: float) -> str:
    if math.isinf(bound):
        return f"Estimates do not know so low a drop; so {found.drops} drops were counted."
    alone = not_enough(f"{method} alone", bound, target_error)
    if found.method == HYBRID:
        return f"{alone}; so {found.drops} drops were added."
    if any(line.startswith("CONFLICT:") for line in found.warnings):
        return f"{alone}, and drops contradict it; so {found.drops} drops were counted."
    return f"{alone}, and worth too few drops to matter; so {found.drops} drops were counted."
