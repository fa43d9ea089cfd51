"""Compares every estimator with a dataset."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...estimators.registry import ESTIMATORS
from ...resting.poses import RestingPoses
from ..dataset import Dataset
from ..errors.calibration import calibration
from ..errors.partition import accuracy, sensitivity
from ..errors.simulated_poses import SimulatedPoses, pooled
from ..estimates import restings, scene_estimates
from ..noise import noise_of
from . import paper
from .combined import combined_row
from .outliers import outliers
from .refits import refits
from .results import Row, Shapes, TableResults

Array = NDArray[np.float64]


def table(dataset: Dataset, *, rerun: bool = True,
          on_progress: Callable[[int], object] = lambda _: None) -> TableResults:
    """Table I for one dataset, and what the paper's sections 4 and 5.A say beside it.

    Parameters
    ----------
    dataset : Dataset
    rerun : bool
        Drop the outliers again.
    on_progress : callable, optional
        Told how many bodies are done.
    """
    begin = time.perf_counter()
    poses = restings(dataset, on_progress)
    found = scene_estimates(dataset, poses)
    first = dataset.spec.block_ends[0]
    with ThreadPoolExecutor(1) as pool:  # the drops' kernels leave the interpreter free
        again = pool.submit(outliers, dataset, _first(found)["combined"], first) if rerun else None
        results = _compared(dataset, found, poses, first)
        dropped = tuple(again.result()) if again else ()
    return replace(results, outliers=dropped, seconds=time.perf_counter() - begin)


def _compared(dataset: Dataset, found: dict[float, dict[str, Array]], poses: list[RestingPoses],
              first: int) -> TableResults:
    """All but the outliers."""
    spec = dataset.spec
    single = {one: dataset.simulated(one) for one in spec.restitutions}
    of_first = {one: dataset.simulated(one, first) for one in spec.restitutions}
    every, every_first = pooled(list(single.values())), pooled(list(of_first.values()))
    apart = sensitivity(single[min(single)], single[max(single)]) if len(single) > 1 else None
    return TableResults(
        spec=spec, shapes=_shapes(dataset, of_first),
        rows=tuple(_row(name, {rho: told[name] for rho, told in found.items()}, single, every,
                        every_first) for name in _first(found)),
        first=first, pooled_noise=noise_of(every, paper.DROPS),
        noise={one: noise_of(simulated, paper.DROPS) for one, simulated in single.items()},
        sensitivity=apart,
        combined=combined_row(dataset, poses, first) if spec.drops > first else None,
        calibration={one: calibration(of_first[one], dataset.rest(one, first))
                     for one in spec.restitutions if spec.drops > first},
        refits=tuple(refits(_first(found), every, single, poses)), outliers=(), estimates=found,
        seconds=0.0)


def _row(name: str, values: dict[float, Array], single: dict[float, SimulatedPoses],
         every: SimulatedPoses, every_first: SimulatedPoses) -> Row:
    repeated = np.concatenate([values[one] for one in single])
    return Row(name, ESTIMATORS[name].title, accuracy(repeated, every),
               {one: accuracy(values[one], simulated) for one, simulated in single.items()},
               accuracy(repeated, every_first))


def _first(found: dict[float, dict[str, Array]]) -> dict[str, Array]:
    """Of methods that are blind to restitution."""
    return next(iter(found.values()))


def _shapes(dataset: Dataset, first: dict[float, SimulatedPoses]) -> Shapes:
    arrays, spec = dataset.arrays, dataset.spec
    drops = spec.bodies * len(spec.restitutions) * spec.drops
    vertices = arrays["vertices"].astype(np.int64)
    return Shapes(
        values=len(dataset.body) * len(first), mean_poses=float(arrays["poses"].mean()),
        poses=_range(arrays["poses"]), vertices=_range(vertices),
        faces=_range(arrays["triangles"]), redraws=int(arrays["redraws"].sum()),
        unsettled=drops - int(arrays["settled"].sum()),
        largest_probability=float(max(one.probability.max() for one in first.values())))


def _range(values: NDArray[np.generic]) -> tuple[int, int]:
    return int(values.min()), int(values.max())
