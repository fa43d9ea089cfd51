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

"""Fits the expected errors of the estimators, and compares them with true ones on new
bodies.

.venv/bin/python -m lab.training.expected_errors [--methods NAME ...] [--write]
"""

from collections.abc import Collection, Iterator

from lab.benchmarks.program import benchmark_parser, run_benchmark
from lab.frame.results import Section
from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.estimators.fitted import ERROR_FITS

from ..split.samples import FIT_SEED, JUDGE_SEED, read_samples
from .fit import fit_errors, usual_errors, write_weights
from .judge import judged, sections
from .samples import error_samples


def fit_and_judge(is_shipped: bool, methods: Collection[str]) -> Iterator[Section]:
    """Fit some methods, and compare all with true errors.

    Shipped fits are written into the package; the others keep those that they have.
    """
    samples = read_samples()
    fit_samples = error_samples(
        [sample for sample in samples if sample.seed == FIT_SEED], methods
    )
    fits = {
        name: fit_errors(fit_samples[name]) if name in methods else ERROR_FITS[name]
        for name in ESTIMATORS
    }
    if is_shipped:
        write_weights(fits, usual_errors())
    else:
        print(fits)
    yield from sections(
        judged([sample for sample in samples if sample.seed == JUDGE_SEED], fits)
    )


def main() -> None:
    """Read the arguments, fit and judge."""
    parser = benchmark_parser("lab.training.expected_errors", __doc__ or "")
    parser.add_argument(
        "--methods",
        nargs="+",
        choices=ESTIMATORS,
        default=list(ESTIMATORS),
        help="to be fitted; the others keep their fits (default: all)",
    )
    run_benchmark(parser, lambda options: fit_and_judge(options.write, options.methods))


if __name__ == "__main__":
    main()
