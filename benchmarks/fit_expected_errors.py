"""Fits the expected errors of the estimators, for `estimators/error_weights.py`.

    .venv/bin/python -m benchmarks.fit_expected_errors [--write]

The square error of each part of the reference datasets, against the drop simulation with the
noise taken off, is fitted by terms that are known without simulation (`estimators.expected`), with
weights that are not negative. Parts count by the inverse square of what is expected of them, so
that small errors are met as well as large ones.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from ros_pose_stats.benchmark.dataset import Dataset, shipped_datasets
from ros_pose_stats.benchmark.estimates import restings, scene_estimates, square_errors
from ros_pose_stats.estimators.expected import error_terms
from ros_pose_stats.estimators.registry import ESTIMATORS
from ros_pose_stats.geometry.poses import RestingPoses

Array = NDArray[np.float64]

RESTITUTIONS = (0.2, 0.5, 0.8)
ROUNDS = 30
LEAST = 1e-5
"""Smallest expected square that a part is weighted by."""

MODULE = Path(__file__).resolve().parents[1] / "ros_pose_stats/estimators/error_weights.py"


class Sample(NamedTuple):
    """One method on all parts: terms (B, 5) and square errors (B,), by restitution."""

    terms: dict[float, Array]
    squares: dict[float, Array]


def samples() -> dict[str, Sample]:
    """By the method's name, over all reference datasets."""
    parts = [_sample(dataset) for dataset in shipped_datasets()]
    return {name: Sample({rho: np.vstack([one[name].terms[rho] for one in parts])
                          for rho in RESTITUTIONS},
                         {rho: np.concatenate([one[name].squares[rho] for one in parts])
                          for rho in RESTITUTIONS}) for name in parts[0]}


def _sample(dataset: Dataset) -> dict[str, Sample]:
    poses = restings(dataset)
    ends = dataset.pose_starts[1:-1]
    told = scene_estimates(dataset, poses)
    return {name: Sample({rho: _terms(poses, np.split(told[rho][name], ends))
                          for rho in RESTITUTIONS},
                         {rho: square_errors(told[rho][name], dataset.simulated(rho))
                          for rho in RESTITUTIONS})
            for name in ESTIMATORS}


def _terms(poses: list[RestingPoses], values: list[Array]) -> Array:
    return np.array([error_terms(one, some) for one, some in zip(poses, values, strict=True)])


def fitted(terms: Array, squares: Array) -> Array:
    """Weights (5,) of the terms."""
    weight = np.ones(len(squares))
    for _ in range(ROUNDS):
        found, _ = nnls(terms * weight[:, None], squares * weight)
        weight = 1.0 / np.maximum(terms @ found, LEAST)
    return np.asarray(found)


def source(told: dict[str, Sample]) -> str:
    """The module that holds the weights."""
    weights, usual = [], []
    for name in ESTIMATORS:
        rows = [fitted(told[name].terms[rho], told[name].squares[rho]) for rho in RESTITUTIONS]
        lines = [f'        ({", ".join(f"{value:.4g}" for value in row)}),' for row in rows]
        weights.append("\n".join([f'    "{name}": (', *lines, "    ),"]))
        usual.append(f'    "{name}": (' + ", ".join(
            f"{np.sqrt(told[name].squares[rho].mean()):.3f}" for rho in RESTITUTIONS) + "),")
    return TEXT.format(RESTITUTIONS, "\n".join(weights), "\n".join(usual))


TEXT = '''"""Weights of expected errors, written by `python -m benchmarks.fit_expected_errors`."""

from __future__ import annotations

from typing import Final

ERROR_AT: Final = {}
"""Restitutions of the tuples below."""

ERROR_WEIGHTS: Final[dict[str, tuple[tuple[float, ...], ...]]] = {{
{}
}}
"""Of the terms of `expected.error_terms`, at each restitution."""

USUAL_ERRORS: Final[dict[str, tuple[float, ...]]] = {{
{}
}}
"""Root mean square error over the parts of the reference datasets, as a fraction."""
'''


def main() -> None:
    """Fit, and print or write."""
    parser = argparse.ArgumentParser(prog="benchmarks.fit_expected_errors",
                                     description=__doc__.partition("\n")[0])
    parser.add_argument("--write", action="store_true", help=f"write {MODULE.name}")
    write = parser.parse_args().write
    text = source(samples())
    if write:
        MODULE.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
