"""The comparison of every estimator with a dataset."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.planning.confidence import pose_prior
from ros_pose_stats.core.records import DropScene
from ros_pose_stats.core.resting.poses import RestingPoses
from ros_pose_stats.core.simulation.simulate import simulate

from .. import paper
from ..dataset import Dataset
from ..errors.calibration import calibration
from ..errors.partition import accuracy, noise_of, sensitivity
from ..errors.simulated_poses import SimulatedPoses, pooled
from ..estimates import restings, scene_estimates
from .refits import refits
from .table_results import CombinedRow, Outlier, Row, Shapes, TableResults

Array = NDArray[np.float64]


def table(
    dataset: Dataset,
    *,
    rerun: bool = True,
    on_progress: Callable[[int], object] = lambda _: None,
) -> TableResults:
    """Make Table I for one dataset, and the figures of the paper's sections 4 and 5.A.

    Parameters
    ----------
    dataset : Dataset
    rerun : bool
        Whether to drop the outliers again.
    on_progress : callable, optional
        Called with the number of bodies done.
    """
    begin = time.perf_counter()
    poses = restings(dataset, on_progress)
    found = scene_estimates(dataset, poses)
    first = dataset.spec.block_ends[0]
    with ThreadPoolExecutor(1) as pool:  # the drops' kernels leave the interpreter free
        again = (
            pool.submit(outliers, dataset, _first(found)["combined"], first)
            if rerun
            else None
        )
        results = _compared(dataset, found, poses, first)
        dropped = tuple(again.result()) if again else ()
    return replace(results, outliers=dropped, seconds=time.perf_counter() - begin)


def _compared(
    dataset: Dataset,
    found: dict[float, dict[str, Array]],
    poses: list[RestingPoses],
    first: int,
) -> TableResults:
    """All results but the outliers."""
    spec = dataset.spec
    single = {one: dataset.simulated(one) for one in spec.restitutions}
    of_first = {one: dataset.simulated(one, first) for one in spec.restitutions}
    every = pooled(list(single.values()))
    every_first = pooled(list(of_first.values()))
    apart = (
        sensitivity(single[min(single)], single[max(single)])
        if len(single) > 1
        else None
    )
    return TableResults(
        spec=spec,
        shapes=_shapes(dataset, of_first),
        rows=tuple(
            _row(
                name,
                {rho: told[name] for rho, told in found.items()},
                single,
                every,
                every_first,
            )
            for name in _first(found)
        ),
        first=first,
        pooled_noise=noise_of(every, paper.DROPS),
        noise={
            one: noise_of(simulated, paper.DROPS) for one, simulated in single.items()
        },
        sensitivity=apart,
        combined=combined_row(dataset, poses, first) if spec.drops > first else None,
        calibration={
            one: calibration(of_first[one], dataset.rest(one, first))
            for one in spec.restitutions
            if spec.drops > first
        },
        refits=tuple(refits(_first(found), every, single)),
        outliers=(),
        estimates=found,
        seconds=0.0,
    )


def _row(
    name: str,
    values: dict[float, Array],
    single: dict[float, SimulatedPoses],
    every: SimulatedPoses,
    every_first: SimulatedPoses,
) -> Row:
    repeated = np.concatenate([values[one] for one in single])
    return Row(
        name,
        ESTIMATORS[name].title,
        accuracy(repeated, every),
        {one: accuracy(values[one], simulated) for one, simulated in single.items()},
        accuracy(repeated, every_first),
    )


def _first(found: dict[float, dict[str, Array]]) -> dict[str, Array]:
    """Estimates at the first restitution, for methods that do not know it."""
    return next(iter(found.values()))


def _shapes(dataset: Dataset, first: dict[float, SimulatedPoses]) -> Shapes:
    arrays = dataset.arrays
    spec = dataset.spec
    drops = spec.bodies * len(spec.restitutions) * spec.drops
    vertices = arrays["vertices"].astype(np.int64)
    return Shapes(
        values=len(dataset.body) * len(first),
        mean_poses=float(arrays["poses"].mean()),
        poses=_range(arrays["poses"]),
        vertices=_range(vertices),
        faces=_range(arrays["triangles"]),
        redraws=int(arrays["redraws"].sum()),
        unsettled=drops - int(arrays["settled"].sum()),
        largest_probability=float(max(one.probability.max() for one in first.values())),
    )


def _range(values: NDArray[np.generic]) -> tuple[int, int]:
    return int(values.min()), int(values.max())


def combined_row(
    dataset: Dataset, poses: list[RestingPoses], first: int
) -> CombinedRow:
    """Make the row of hybrid with the first drops, compared with all the others.

    Parameters
    ----------
    dataset : Dataset
        With more drops than the first ones.
    poses : list of RestingPoses
        Of all bodies.
    first : int
        Number of the first drops.
    """
    rest = {one: dataset.rest(one, first) for one in dataset.spec.restitutions}
    told = {
        one: _combined_values(
            poses,
            dataset.simulated(one, first),
            DropScene(one, dataset.spec.drop_height, 0.0, 0),
        )
        for one in rest
    }
    every = accuracy(np.concatenate(list(told.values())), pooled(list(rest.values())))
    return CombinedRow(
        f"hybrid, {first} drops",
        every,
        {one: accuracy(told[one], rest[one]) for one in rest},
    )


def _combined_values(
    poses: list[RestingPoses], counted: SimulatedPoses, scene: DropScene
) -> Array:
    """Probabilities by hybrid of all bodies' poses."""
    ends = np.cumsum([len(one.poses) for one in poses])[:-1]
    return np.concatenate(
        [
            pose_prior(one, scene).update(counts).probability
            for one, counts in zip(poses, np.split(counted.count, ends), strict=True)
        ]
    )


NUMBER = 3
MORE_DROPS = (1_000, 10_000)


def outliers(dataset: Dataset, estimate: Array, first: int) -> list[Outlier]:
    """The largest deviations among the first drops, of different bodies, dropped again.

    Parameters
    ----------
    dataset : Dataset
    estimate : (P,) array
        The estimator's probabilities.
    first : int
        Number of the first drops.
    """
    seen = np.stack(
        [
            dataset.simulated(one, first).probability
            for one in dataset.spec.restitutions
        ],
        axis=1,
    )
    return [
        _again(dataset, float(estimate[pose]), pose, which, float(seen[pose, which]))
        for pose, which in _largest(dataset, np.abs(seen - estimate[:, None]))
    ]


def _largest(dataset: Dataset, away: Array) -> Iterator[tuple[int, int]]:
    """Poses and places of restitutions, the worst first, each body once."""
    seen: set[int] = set()
    for place in np.argsort(-away, axis=None, kind="stable").tolist():
        pose, which = divmod(place, away.shape[1])
        body = int(dataset.body[pose])
        if body not in seen:
            seen.add(body)
            yield pose, which
        if len(seen) == NUMBER:
            return


def _again(
    dataset: Dataset, estimate: float, pose: int, which: int, first: float
) -> Outlier:
    """Drop an outlier afresh, since the drops by which it was found are biased."""
    spec = dataset.spec
    body = int(dataset.body[pose])
    restitution = spec.restitutions[which]
    number = pose - int(dataset.pose_starts[body])
    part = dataset.part(body)
    found = []
    for run, drops in enumerate(MORE_DROPS, 1):
        told = simulate(
            part,
            drops,
            restitution,
            spec.drop_seed(body, restitution, run),
            spec.drop_height,
            cluster_tolerance=0.0,
            round_sides=0,
        )
        found.append(
            (drops, next(one.probability for one in told.poses if one.index == number))
        )
    return Outlier(body, number, restitution, estimate, first, tuple(found))
