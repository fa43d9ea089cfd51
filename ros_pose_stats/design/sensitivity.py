"""How the share of wanted poses changes with each thing that can be changed on a part.

Derivatives come from the fast estimator, fitted over steps to both sides; those that matter most
are checked by drops of the part before and after from the same starts.
"""

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..errors import MeshError, RequestError
from ..estimators import estimate_in
from ..methods import AUTO
from ..records import DropScene, Part, scene as scenes
from ..simulation.request import drop_request
from ..statistics import feeding, pose_groups, pose_shares
from ..tolerances import number_equal
from . import alike, changes, shares
from .effects import Effect, Sensitivity, check_effects, effect_error

STEP = 0.05
"""Of the radius, and of stretching as a fraction: a change that a designer would make. What less
does is lost in the estimator's own unevenness (docs/measured/design.md)."""

SAME_CHANGE = 1e-9
"""Changes of a share this close are a tie: by symmetry both ways change it alike."""

CHECKS = 5
CHECK_DROPS = 2000
"""Effects that are checked, and the drops of each part."""

CHECK_SECONDS = 1.0
"""Time after which no further drops are begun, where their number was not given."""

def sensitivity(part: Part, wanted: Sequence[int], *, step: float | None = None,
                checks: int = CHECKS, drops: int | None = None, seed: int | None = None,
                restitution: float = scenes.DEFAULT_RESTITUTION, drop_height: float | None = None,
                cluster_tolerance: float = scenes.DEFAULT_CLUSTER_TOLERANCE,
                round_sides: int = scenes.DEFAULT_ROUND_SIDES, workers: int | None = None,
                on_progress: Callable[[float], object] | None = None,
                should_stop: Callable[[], bool] | None = None) -> Sensitivity:
    """How the share of wanted poses changes with centre of mass, proportions and faces.

    Parameters
    ----------
    part : Part
    wanted : sequence of int
        Indices of the accepted poses.
    step : float, optional
        Change that is meant, metres; default: a twentieth of the radius. Stretching is by the
        same share of the radius.
    checks : int
        Effects that are checked by drops, those that raise the share most.
    drops : int, optional
        Drops of each part for a check. Default: 2 000, and no more are begun after a second;
        with a number and a seed the same request gives the same counts.
    seed : int, optional
        Of the drops; default: a fresh one.
    restitution, drop_height, cluster_tolerance, round_sides, workers
        As for `simulate`.
    on_progress : callable, optional
        Takes the share done, 0 to 1.
    should_stop : callable, optional
        After True what is known by then is returned.

    Raises
    ------
    RequestError
        If a value is out of its range or there is no such pose.
    """
    begin = time.perf_counter()
    scene = DropScene(restitution, drop_height, cluster_tolerance, round_sides)
    asked = drop_request(CHECK_DROPS if drops is None else drops, seed, 0.0, workers, None)
    space = changes.DesignSpace(part, cluster_tolerance, round_sides)
    model = shares.WantedShare(space, wanted, scene)
    reach = check_step(STEP * space.body.radius if step is None else step, space.body.radius)
    told = estimate_in(part, model.scene, AUTO)
    stop, progress = should_stop or (lambda: False), on_progress or (lambda done: None)
    effects = _effects(space, model, reach, asked.workers,
                       lambda share: progress(0.5 * share), stop)
    best = sorted((one for one in effects if one.helps), key=lambda one: -one.change)[:checks]
    dropped, out_of_time = 0, False
    if best and not stop():
        changed = [space.change_one(one.number, one.step) for one in best]
        checked, done = check_effects(
            best, [space.change_one(0, 0.0), *changed], model, asked,
            CHECK_SECONDS if drops is None else None,
            lambda share: progress(0.5 + 0.5 * share), stop)
        dropped, out_of_time = done.pairs.drops, done.out_of_time
        known = {one.number: one for one in checked}
        effects = [known.get(one.number, one) for one in effects]
    kept = tuple(np.flatnonzero(model.kept).tolist())
    return Sensitivity(space, kept, model.scene, told.method,
                       feeding.drop_afresh(pose_shares.pose_shares(told), kept).accepted, reach,
                       tuple(effects), dropped, asked.seed, asked.drops, out_of_time,
                       time.perf_counter() - begin,
                       (*told.warnings, *pose_groups.warn_of_alike(told, kept)))


def check_step(step: float, radius: float) -> float:
    """Refuse a step that no small change is.

    Raises RequestError if it is not above 0 and at most half a radius.
    """
    if not 0.0 < step <= 0.5 * radius:
        raise RequestError(f"a step above 0 and at most {500.0 * radius:.3g} mm, half the part's "
                           "radius", f"{1e3 * step:.3g} mm", "leave it out for a twentieth of "
                           "the radius")
    return step


def _effects(space: changes.DesignSpace, model: shares.WantedShare, reach: float, workers: int,
             progress: Callable[[float], object], stop: Callable[[], bool]) -> list[Effect]:
    first = alike.alike(space, model.kept)
    numbers = np.unique(first)
    base = model.estimate(space.change_one(0, 0.0))
    done = 0

    def one(number: int) -> Effect | None:
        nonlocal done
        if stop():
            return None
        same = tuple(np.flatnonzero(first == number).tolist())
        found = _effect(space, model, base, same, reach)
        done += 1
        progress(done / len(numbers))
        return found

    with ThreadPoolExecutor(workers) as pool:
        found = [effect for effect in pool.map(one, numbers.tolist())
                 if effect is not None]
    rank = number_equal([-abs(effect.change) for effect in found], SAME_CHANGE)
    return [found[k] for k in sorted(range(len(found)), key=lambda k: (rank[k], found[k].number))]


def _effect(space: changes.DesignSpace, model: shares.WantedShare, base: float,
            same: tuple[int, ...],
            reach: float) -> Effect | None:
    """Effect of the first of some features alike; None where no body remains after the step."""
    number = same[0]
    feature = space.features[number]
    unit = reach if feature.is_length else reach / space.body.radius
    sides = (-unit, unit)
    try:
        after = [space.change_one(number, side) for side in sides]
    except MeshError:
        return None
    other, change = (model.estimate(one) - base for one in after)
    slope = 0.5 * (change - other)
    error = effect_error(slope, 0.5 * abs(change + other))
    place = 0 if other > change + SAME_CHANGE else 1
    return Effect(feature, number, same, slope / unit, error / unit,
                  sides[place], (other, change)[place], model.lost(after[place]))
