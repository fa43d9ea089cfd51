"""Counts of a part combined with its estimate, against either alone, on the simulated
plates.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.estimators.estimate import estimate_in
from ros_pose_stats.core.planning.confidence import (
    learn_plate_error,
    observe_counts,
    plate_evidence,
)
from ros_pose_stats.core.records import DropScene, PoseStatistics, StablePose

from .friction import read_counts, study_parts

COUNTS = (30, 100, 300, 1000)
"""Of each of all parts, drawn from the shares that the plate's counts have."""

SOURCES = ("estimate", "counts", "observed", "observed, 5 points assumed")


def observed_errors(repeats: int, seed: int) -> dict[int, dict[str, float]]:
    """Root mean square errors over groups, parts and plates, by counts of a part and
    way.
    """
    models = [estimate_in(part, DropScene(), "split") for part in study_parts()]
    errors: dict[int, dict[str, float]] = {}
    for counted in COUNTS:
        squares: dict[str, list[float]] = {method: [] for method in SOURCES}
        for plate, counts in enumerate(read_counts()):
            for repeat in range(repeats):
                random = np.random.default_rng((seed, counted, plate, repeat))
                true = [np.array(count) / sum(count) for count in counts]
                samples = [random.multinomial(counted, shares) for shares in true]
                evidence = [
                    plate_evidence(model, count)
                    for model, count in zip(models, samples, strict=True)
                ]
                for row, (model, count) in enumerate(zip(models, samples, strict=True)):
                    learnt = learn_plate_error(evidence[:row] + evidence[row + 1 :])
                    answers = (
                        shares_of(model),
                        count / counted,
                        shares_of(
                            observe_counts(replace(model, plate_error=learnt), count)
                        ),
                        shares_of(observe_counts(model, count)),
                    )
                    group = np.array([pose.group for pose in by_index(model)])
                    for method, answer in zip(SOURCES, answers, strict=True):
                        error = np.bincount(group, answer - true[row])
                        squares[method].append(float(np.square(error).mean()))
        errors[counted] = {
            method: math.sqrt(float(np.mean(of_method)))
            for method, of_method in squares.items()
        }
    return errors


def by_index(model: PoseStatistics) -> list[StablePose]:
    """Its poses."""
    return sorted(model.poses, key=lambda pose: pose.index)


def shares_of(model: PoseStatistics) -> NDArray[np.float64]:
    """Probabilities (P,) by index."""
    return np.array([pose.probability for pose in by_index(model)])
