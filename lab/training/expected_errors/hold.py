"""Expected errors of families that the fit of the errors did not see.

.venv/bin/python -m lab.training.expected_errors.hold [--every N]

One family at a time is left out of the fit; the estimator itself has seen other bodies
of it (`python -m lab.training.split hold` fits that without some families).
"""

from __future__ import annotations

import argparse

import numpy as np

from ros_pose_stats.core.estimators import best_method
from ros_pose_stats.core.records.scene import DEFAULT_RESTITUTION

from ..split.samples import FIT_SEED, JUDGE_SEED, Sample, read_samples
from .fit import fit_errors
from .judge import Judged, judged
from .samples import ErrorSamples, error_samples


def joined(parts: list[ErrorSamples]) -> ErrorSamples:
    """Samples of several families as one."""
    return ErrorSamples(
        *(np.concatenate(column) for column in zip(*parts, strict=True))
    )


def true_over_expected(judgement: Judged) -> float:
    """Ratio of the root mean squares over the poses, the drops' noise taken off."""
    weights = judgement.poses
    true = np.average(judgement.square - judgement.noise, weights=weights)
    return float(
        np.sqrt(max(true, 0.0) / np.average(judgement.expected, weights=weights))
    )


def by_family(samples: list[Sample]) -> dict[str, list[Sample]]:
    """Samples by the name of their family."""
    families: dict[str, list[Sample]] = {}
    for sample in samples:
        families.setdefault(sample.family, []).append(sample)
    return families


def main() -> None:
    """Print a table, a family a row."""
    parser = argparse.ArgumentParser(
        prog="lab.training.expected_errors.hold",
        description=(__doc__ or "").partition("\n")[0],
    )
    parser.add_argument(
        "--every",
        type=int,
        default=4,
        help="fit to every so many bodies (default: %(default)s)",
    )
    options = parser.parse_args()
    method = best_method(DEFAULT_RESTITUTION)
    samples = read_samples()
    fit_samples = by_family(
        [
            sample
            for sample in samples
            if sample.seed == FIT_SEED and sample.number % options.every == 0
        ]
    )
    inputs = {
        family: error_samples(rows, [method])[method]
        for family, rows in fit_samples.items()
    }
    whole_fit = fit_errors(joined(list(inputs.values())))
    print("| family | in the fit | left out | kept, in the fit | kept, left out |")
    print("| --- | ---: | ---: | ---: | ---: |")
    for family, rows in by_family(
        [sample for sample in samples if sample.seed == JUDGE_SEED]
    ).items():
        others = [columns for name, columns in inputs.items() if name != family]
        fits = (
            whole_fit,
            fit_errors(joined(others)) if family in inputs else whole_fit,
        )
        judgements = [judged(rows, {method: fit})[method] for fit in fits]
        cells = [f"{true_over_expected(judgement):.2f}" for judgement in judgements]
        cells += [f"{100.0 * judgement.kept.mean():.1f}" for judgement in judgements]
        print(f"| {family} |", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()
