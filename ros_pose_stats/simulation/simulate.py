"""From a part to its pose statistics by dropping it."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..methods import SIMULATION
from ..records import DropProgress, DropScene, Part, PoseStatistics
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_RESTITUTION, HIGH_DROP_RADII
from ..records.statistics import ranked
from ..resting.trust import drop_warnings, pose_warnings
from ..statistics.prefix import Judge, Prefix
from ..statistics.stopping import target_reached
from ..version import VERSION
from .chunks import ChunkRun
from .drop_body import PreparedBody, drop_body
from .drops import DropChunk, DropOutcomes, drop_rules, release_height, run
from .request import DropRequest, drop_request
from .starts import starting_directions

Array = NDArray[np.float64]


def simulate(part: Part, drops: int | None = None, restitution: float = DEFAULT_RESTITUTION,
             seed: int | None = None, drop_height: float | None = None,
             target_error: float = 0.0, workers: int | None = None, sampling: str = "random",
             starts: ArrayLike | None = None,
             on_progress: Callable[[DropProgress], object] | None = None,
             should_stop: Callable[[], bool] | None = None, *,
             on_drops: Callable[[DropChunk], object] | None = None,
             background: bool = False,
             cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE,
             judge: Judge | None = None) -> PoseStatistics:
    """Drop a part many times and count the poses in which it comes to rest (section 3).

    Parameters
    ----------
    part : Part
        As from `load_part` or `part_from_mesh`.
    drops : int, optional
        How many, 1 to 1e9; the most where a target error is given. Default: 10 000, or all
        starts.
    restitution : float
        Coefficient of restitution, 0 <= restitution < 1.
    seed : int, optional
        0 to 2^64 - 1. Drop k depends on the seed and k alone. Default: a fresh one, to be
        found in the answer.
    drop_height : float, optional
        Height of the centre of mass at release, metres; too low to fit means released
        touching the plate. Default: 20 part radii.
    target_error : float
        Stop once the expected error is down to this fraction; looked at after 100, 150, 225,
        ... drops. 0 asks for all drops.
    workers : int, optional
        Threads; default: all cores.
    sampling : {'random', 'lattice'}
        Independent starting directions, or evenly spread ones.
    starts : (k, 3) array, optional
        Directions in the part frame that point down at release, one a drop, in place of
        random ones.
    on_progress : callable, optional
        Told a `DropProgress` some twenty times a second, in the caller's thread.
    should_stop : callable, optional
        Asked as often; True ends the run, within about 50 ms, with what has been done.
    on_drops : callable, optional
        Told every single drop that counts, in order, a `DropChunk` at a time, in the caller's
        thread.
    background : bool
        Let the workers give way to other threads of this machine (Linux: niceness 10).
    cluster_tolerance : float
        Poses merge below this barrier, as a fraction of the radius; 0 merges nothing.
    judge : Judge, optional
        Tells the expected error in place of the counts, and when to look first.

    Returns
    -------
    PoseStatistics
        All stable poses, most probable first; unsettled drops are counted apart. The same
        request gives the same counts, whatever the workers and the timing.

    Raises
    ------
    RequestError
        If a value is out of its range.
    MeshError
        If the part's hull does not enclose its centre of mass.
    """
    begin = time.perf_counter()
    scene = DropScene(restitution, drop_height, cluster_tolerance)
    request = drop_request(drops, seed, target_error, workers, sampling, starts)
    body = drop_body(part, scene.cluster_tolerance)
    prefix = Prefix(len(body.resting.poses), request.drops, request.target_error,
                    request.sampling == "lattice", judge)
    means = Judge.means if judge is None else judge.means
    touched = 0

    def so_far() -> PoseStatistics:
        return _statistics(part, body, scene, request, prefix, touched, means,
                           time.perf_counter() - begin)

    def stop() -> bool:
        return prefix.finished or (should_stop is not None and bool(should_stop()))

    chunks = ChunkRun(_dropper(body, scene, request), request.drops, request.workers, stop,
                      background, prefix.wanted)
    for outcomes in chunks.in_order():
        first, kept = prefix.drops, prefix.add(outcomes.pose)
        if on_drops is not None and kept:
            on_drops(DropChunk(first, _downs(request, first, kept), outcomes.first(kept)))
        touched += int(outcomes.touched[:kept].sum())
        if prefix.finished:
            chunks.stop()
        chunks.want(prefix.wanted)
        if on_progress is not None and kept:
            on_progress(DropProgress(
                prefix.drops, request.drops, prefix.drops - prefix.settled,
                prefix.recent_error(), request.target_error,
                time.perf_counter() - begin, so_far))
    return so_far()


def _dropper(body: PreparedBody, scene: DropScene,
             request: DropRequest) -> Callable[[int, int], DropOutcomes]:
    rules = drop_rules(scene, body.radius)

    def drop(first: int, count: int) -> DropOutcomes:
        return run(body, rules, _downs(request, first, count))

    return drop


def _downs(request: DropRequest, first: int, count: int) -> Array:
    if request.starts is not None:
        return request.starts[first:first + count]
    return starting_directions(request.sampling, request.seed, first, count)


def _statistics(part: Part, body: PreparedBody, scene: DropScene, request: DropRequest,
                prefix: Prefix, touched: int, means: str, seconds: float) -> PoseStatistics:
    settled = prefix.settled
    errors = prefix.standard_errors()
    low, high = prefix.interval()
    probability = prefix.counts / settled if settled else np.full(errors.shape, np.nan)
    rows = zip(body.resting.poses, probability.tolist(), low.tolist(), high.tolist(),
               errors.tolist(), prefix.counts.tolist(), strict=True)
    return PoseStatistics(
        part_id=part.part_id, part_digest=part.digest, radius=body.radius, method=SIMULATION,
        restitution=scene.restitution, drop_height=release_height(scene, body.radius),
        cluster_tolerance=scene.cluster_tolerance,
        poses=ranked([pose.with_probability(*known) for pose, *known in rows]),
        drops=prefix.drops, unsettled=prefix.drops - settled, seed=request.seed,
        expected_error=prefix.expected_error(), seconds=seconds,
        warnings=(*part.warnings, *pose_warnings(body.resting),
                  *drop_warnings(body.resting),
                  *_warnings(scene, body.radius, prefix, touched, means)),
        version=VERSION)


def _warnings(scene: DropScene, radius: float, prefix: Prefix, touched: int,
              means: str) -> list[str]:
    warnings = []
    radii = release_height(scene, radius) / radius
    if radii > HIGH_DROP_RADII:
        warnings.append(
            f"HEIGHT_SUSPECT: released {radii:.3g} radii above the plate; the drop height is in "
            f"metres whatever the unit of the mesh.")
    if prefix.finished and prefix.target_error > 0.0 and not target_reached(
            prefix.expected_error(), prefix.target_error):
        warnings.append(
            f"TARGET_MISSED: the {means} is {prefix.expected_error():.2g} after all "
            f"{prefix.drops} drops, above the target of {prefix.target_error:g}.")
    unsettled = prefix.drops - prefix.settled
    if touched:
        warnings.append(
            f"RELEASED_TOUCHING: in {touched} of {prefix.drops} drops the part did not fit under "
            f"a drop height of {scene.drop_height:g} m and was released touching the plate.")
    if unsettled:
        warnings.append(
            f"UNSETTLED: {unsettled} of {prefix.drops} drops were given up before their pose was "
            f"certain; they are left out of the probabilities.")
    return warnings
