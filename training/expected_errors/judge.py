"""Expected errors beside true ones, on bodies that no fit has seen."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from benchmarks.results import Cell, Row, Section, Target
from ros_pose_stats.estimators import best_method
from ros_pose_stats.estimators.fitted_weights import ErrorFit
from ros_pose_stats.records.scene import DEFAULT_RESTITUTION

from .samples import ErrorSamples

Bools = NDArray[np.bool_]

LEAST = 1e-4
"""True error, a fraction, that stands where the noise of the drops hides it."""

MOST = 1.33
"""Largest factor by which the expected error may be off, either way."""

BINS = 5

BY_FAMILY = (
    "Root mean squares over the poses, in points, of what {} expects of its errors and of the "
    "true ones, the drops' own noise taken off: new bodies of every family, dropped from 20 and "
    "from 2 radii at restitution 0.2, 0.5 and 0.8. The fit knows other bodies of these families, "
    "but for fine ellipsoids, of which it has seen none. Not times.")
BY_METHOD = (
    "The same for all estimators and families together, and expected over true error for the "
    "bodies in fifths, sorted by their expected error. Not times.")


def sections(fits: Mapping[str, ErrorFit], samples: Mapping[str, ErrorSamples]
             ) -> Iterator[Section]:
    """Tables of the best method by family, and of all methods."""
    best = best_method(DEFAULT_RESTITUTION)
    fit, one = fits[best], samples[best]
    yield Section("expected_errors_by_family", "Expected errors of families",
                  BY_FAMILY.format(best), tuple(_families(fit, one)))
    yield Section("expected_errors", "Expected errors of all methods", BY_METHOD,
                  tuple(_method(name, fits[name], some) for name, some in samples.items()))


def _families(fit: ErrorFit, samples: ErrorSamples) -> Iterator[Row]:
    for family in np.unique(samples.family).tolist():
        cells: dict[str, Cell] = {}
        targets: list[Target] = []
        for height in np.unique(samples.height)[::-1].tolist():
            expected, true = _expected_and_true(fit, samples, (samples.family == family)
                                            & (samples.height == height))
            cells |= {f"{height:g} radii: expected": expected, f"{height:g} radii: true": true}
            targets += _within(expected / true, f"{height:g} radii")
        yield Row(family, cells, tuple(targets))


def _method(name: str, fit: ErrorFit, samples: ErrorSamples) -> Row:
    expected, true = _expected_and_true(fit, samples, np.ones(samples.scale.shape, dtype=bool))
    cells: dict[str, Cell] = {"expected": expected, "true": true}
    order = np.argsort(_squares(fit, samples))
    ratios = []
    for place, some in enumerate(np.array_split(order, BINS)):
        keep = np.zeros(order.shape, dtype=bool)
        keep[some] = True
        low, high = _expected_and_true(fit, samples, keep)
        ratios.append(low / high)
        cells[f"fifth {place + 1}"] = ratios[-1]
    worst = max(ratios, key=lambda ratio: abs(math.log(ratio)))
    return Row(name, cells, _within(worst, "worst fifth"))


def _within(ratio: float, where: str) -> tuple[Target, ...]:
    return (Target(f"factor off, {where}", max(ratio, 1.0 / ratio), MOST),)


def _expected_and_true(fit: ErrorFit, samples: ErrorSamples, where: Bools) -> tuple[float, float]:
    """Expected and true root mean square over the poses of some samples, in points."""
    some = samples.some(where)
    expected = np.average(_squares(fit, some), weights=some.poses)
    true = np.average(some.square - some.noise, weights=some.poses)
    return 100.0 * math.sqrt(expected), 100.0 * math.sqrt(max(true, LEAST ** 2))


def _squares(fit: ErrorFit, samples: ErrorSamples) -> NDArray[np.float64]:
    return np.asarray(samples.scale * np.exp(fit(samples.inputs)))
