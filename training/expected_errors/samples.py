"""Square errors of all methods on bodies of many families, with the inputs of the fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.estimators.fitted_inputs import error_inputs, error_scale, known_answers
from ros_pose_stats.estimators.registry import ESTIMATORS
from ros_pose_stats.records import DropScene
from ros_pose_stats.resting.poses import RestingPoses, resting_poses
from training.families import family_part, family_tolerance

from ..split.samples import Sample
from ..split.table import LEAST_DROPS

Array = NDArray[np.float64]

DECIDED = 1e-6
"""Samples with a smaller mean error scale are left out: symmetry leaves one answer."""


class ErrorSamples(NamedTuple):
    """One method on bodies in scenes; U samples.

    Attributes
    ----------
    inputs : (U, 17) array
        As from `fitted_inputs.error_inputs`.
    scale : (U,) array
        Mean of `fitted_inputs.error_scale`.
    square, noise : (U,) arrays
        Mean square distance from the counted shares, and how much of it is the drops' own.
    poses : (U,) array of int
    height : (U,) array
        Of the drop, radii.
    family : (U,) array of str
    """

    inputs: Array
    scale: Array
    square: Array
    noise: Array
    poses: NDArray[np.int64]
    height: Array
    family: NDArray[np.str_]

    def some(self, keep: NDArray[np.bool_]) -> ErrorSamples:
        """The samples (U,) that are to be kept."""
        return ErrorSamples(*(column[keep] for column in self))


def error_samples(samples: Sequence[Sample]) -> dict[str, ErrorSamples]:
    """Samples by the name of the method; a body takes some ten milliseconds."""
    rows: dict[str, list[tuple[object, ...]]] = {name: [] for name in ESTIMATORS}
    for key, scenes in groupby(samples, lambda row: row[:3]):
        resting = resting_poses(family_part(*key), family_tolerance(key[0]), round_sides=0)
        for name, row in _rows(resting, list(scenes)):
            rows[name].append(row)
    return {name: ErrorSamples(*(np.array(column) for column in zip(*found, strict=True)))
            for name, found in rows.items()}


def _rows(resting: RestingPoses, scenes: Sequence[Sample]
          ) -> Iterator[tuple[str, tuple[object, ...]]]:
    blind = {name: entry.function(resting, DropScene()) for name, entry in ESTIMATORS.items()
             if not entry.knows_scene}
    known = known_answers(resting)
    for row in scenes:
        settled = int(row.count.sum())
        if settled < LEAST_DROPS:
            continue
        scene = DropScene(row.restitution, row.height * resting.body.radius,
                          resting.clusters.tolerance)
        share = row.count / settled
        noise = float(np.mean(share * (1.0 - share))) / (settled - 1)
        for name, entry in ESTIMATORS.items():
            estimate = blind[name] if name in blind else entry.function(resting, scene)
            scale = error_scale(resting, estimate, known)
            if scale.mean() > DECIDED:
                square = float(np.mean(np.square(estimate - share)))
                yield name, (error_inputs(resting, estimate, scene, known, scale),
                             float(scale.mean()), square, noise,
                             share.size, row.height, row.family)
