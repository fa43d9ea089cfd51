"""Measures what error to expect of each estimator, for `estimators/coefficients.py`.

    .venv/bin/python -m benchmarks.fit_expected_errors

Root mean square over the reference datasets of an estimator's error against the drop simulation
with the noise removed, at each restitution: all shifts of the centre of mass count alike.
"""

from __future__ import annotations

import math

from ros_pose_stats.benchmark.dataset import shipped_datasets
from ros_pose_stats.benchmark.estimates import estimates, restings
from ros_pose_stats.statistics.partition import accuracy

Errors = dict[str, tuple[float, ...]]


def expected_errors() -> Errors:
    """Of each estimator, at the datasets' restitutions, as fractions."""
    squares: dict[str, list[list[float]]] = {}
    for dataset in shipped_datasets():
        for name, values in estimates(restings(dataset)).items():
            squares.setdefault(name, []).append(
                [accuracy(values, dataset.simulated(one)).error_variance
                 for one in dataset.spec.restitutions])
    return {name: tuple(math.sqrt(sum(column) / len(column)) for column in zip(*rows, strict=True))
            for name, rows in squares.items()}


def main() -> None:
    """Print them as they stand in the source."""
    print("EXPECTED_ERRORS: Final = {")
    for name, errors in expected_errors().items():
        print(f'    "{name}": ({", ".join(f"{error:.3f}" for error in errors)}),')
    print("}")


if __name__ == "__main__":
    main()
