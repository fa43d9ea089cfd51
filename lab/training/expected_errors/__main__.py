"""Fits the expected errors of the estimators, and compares them with true ones on new
bodies.

.venv/bin/python -m lab.training.expected_errors [--write]
"""

from __future__ import annotations

from collections.abc import Iterator

from lab.benchmarks.program import benchmark_parser, run_benchmark
from lab.frame.results import Section

from ..split.samples import FIT_SEED, JUDGE_SEED, read_samples
from .fit import fit_errors, usual_errors, write_weights
from .judge import judged, sections
from .samples import error_samples


def fit_and_judge(is_shipped: bool) -> Iterator[Section]:
    """Fit, and compare with true errors; shipped fits are written into the package."""
    samples = read_samples()
    fit_samples = error_samples(
        [sample for sample in samples if sample.seed == FIT_SEED]
    )
    fits = {name: fit_errors(of_method) for name, of_method in fit_samples.items()}
    if is_shipped:
        write_weights(fits, usual_errors())
    else:
        print(fits)
    yield from sections(
        judged([sample for sample in samples if sample.seed == JUDGE_SEED], fits)
    )


if __name__ == "__main__":
    run_benchmark(
        benchmark_parser("lab.training.expected_errors", __doc__ or ""),
        lambda options: fit_and_judge(options.write),
    )
