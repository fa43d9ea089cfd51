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

"""The comparison of every estimator with a dataset."""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.planning.confidence import pose_prior
from ros_pose_stats.core.records import Array, DropScene
from ros_pose_stats.core.resting.poses import RestingPoses
from ros_pose_stats.core.simulation.simulate import simulate

from .. import paper
from ..dataset import Dataset
from ..errors.partition import accuracy, noise_of, sensitivity
from ..errors.simulated_poses import SimulatedPoses, pooled
from ..estimates import restings, scene_estimates
from .table_results import Outlier, Row, Shapes, TableResults


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
    estimates = scene_estimates(dataset, poses)
    first = dataset.spec.block_ends[0]
    with ThreadPoolExecutor(1) as pool:  # the drops' kernels leave the interpreter free
        dropped_again = (
            pool.submit(
                outliers, dataset, _first_estimates(estimates)["combined"], first
            )
            if rerun
            else None
        )
        results = _compared(dataset, estimates, poses, first)
        dropped = tuple(dropped_again.result()) if dropped_again else ()
    return replace(results, outliers=dropped, seconds=time.perf_counter() - begin)


def _compared(
    dataset: Dataset,
    estimates: dict[float, dict[str, Array]],
    poses: list[RestingPoses],
    first: int,
) -> TableResults:
    """All results but the outliers."""
    spec = dataset.spec
    single = {
        restitution: dataset.simulated(restitution) for restitution in spec.restitutions
    }
    of_first = {
        restitution: dataset.simulated(restitution, first)
        for restitution in spec.restitutions
    }
    all_drops = pooled(list(single.values()))
    first_drops = pooled(list(of_first.values()))
    difference = (
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
                {rho: shares[name] for rho, shares in estimates.items()},
                single,
                all_drops,
                first_drops,
            )
            for name in _first_estimates(estimates)
        ),
        first=first,
        pooled_noise=noise_of(all_drops, paper.DROPS),
        noise={
            restitution: noise_of(simulated, paper.DROPS)
            for restitution, simulated in single.items()
        },
        sensitivity=difference,
        combined=combined_row(dataset, poses, first) if spec.drops > first else None,
        outliers=(),
        estimates=estimates,
        seconds=0.0,
    )


def _row(
    name: str,
    values: dict[float, Array],
    single: dict[float, SimulatedPoses],
    all_drops: SimulatedPoses,
    first_drops: SimulatedPoses,
) -> Row:
    repeated = np.concatenate([values[restitution] for restitution in single])
    return Row(
        name,
        ESTIMATORS[name].title,
        accuracy(repeated, all_drops),
        {
            restitution: accuracy(values[restitution], simulated)
            for restitution, simulated in single.items()
        },
        accuracy(repeated, first_drops),
    )


def _first_estimates(estimates: dict[float, dict[str, Array]]) -> dict[str, Array]:
    """Estimates at the first restitution, for methods that do not know it."""
    return next(iter(estimates.values()))


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
        largest_probability=float(
            max(simulated.probability.max() for simulated in first.values())
        ),
    )


def _range(values: NDArray[np.generic]) -> tuple[int, int]:
    return int(values.min()), int(values.max())


def combined_row(dataset: Dataset, poses: list[RestingPoses], first: int) -> Row:
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
    remaining = {
        restitution: dataset.remaining_drops(restitution, first)
        for restitution in dataset.spec.restitutions
    }
    shares = {
        restitution: _combined_values(
            poses,
            dataset.simulated(restitution, first),
            DropScene(restitution, dataset.spec.drop_height, 0.0, 0),
        )
        for restitution in remaining
    }
    pooled_error = accuracy(
        np.concatenate(list(shares.values())), pooled(list(remaining.values()))
    )
    return Row(
        "hybrid",
        f"hybrid, {first} drops",
        pooled_error,
        {
            restitution: accuracy(shares[restitution], remaining[restitution])
            for restitution in remaining
        },
    )


def _combined_values(
    poses: list[RestingPoses], counted: SimulatedPoses, scene: DropScene
) -> Array:
    """Probabilities by hybrid of all bodies' poses."""
    ends = np.cumsum([len(resting.poses) for resting in poses])[:-1]
    return np.concatenate(
        [
            pose_prior(resting, scene).update(counts).probability
            for resting, counts in zip(
                poses, np.split(counted.count, ends), strict=True
            )
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
    simulated = np.stack(
        [
            dataset.simulated(restitution, first).probability
            for restitution in dataset.spec.restitutions
        ],
        axis=1,
    )
    return [
        _drop_again(
            dataset, float(estimate[pose]), pose, column, float(simulated[pose, column])
        )
        for pose, column in _largest(dataset, np.abs(simulated - estimate[:, None]))
    ]


def _largest(dataset: Dataset, away: Array) -> Iterator[tuple[int, int]]:
    """Poses and places of restitutions, the worst first, each body once."""
    bodies: set[int] = set()
    for rank in np.argsort(-away, axis=None, kind="stable").tolist():
        pose, column = divmod(rank, away.shape[1])
        body = int(dataset.body[pose])
        if body not in bodies:
            bodies.add(body)
            yield pose, column
        if len(bodies) == NUMBER:
            return


def _drop_again(
    dataset: Dataset, estimate: float, pose: int, column: int, first: float
) -> Outlier:
    """Drop an outlier afresh, since the drops by which it was found are biased."""
    spec = dataset.spec
    body = int(dataset.body[pose])
    restitution = spec.restitutions[column]
    number = pose - int(dataset.pose_starts[body])
    part = dataset.part(body)
    shares = []
    for run, drops in enumerate(MORE_DROPS, 1):
        statistics = simulate(
            part,
            drops,
            restitution,
            spec.drop_seed(body, restitution, run),
            spec.drop_height,
            cluster_tolerance=0.0,
            round_sides=0,
        )
        shares.append(
            (
                drops,
                next(
                    stable_pose.probability
                    for stable_pose in statistics.poses
                    if stable_pose.index == number
                ),
            )
        )
    return Outlier(body, number, restitution, estimate, first, tuple(shares))
