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

"""Fits the prior of `hybrid`, how estimates err, for `statistics/fitted_prior.py`.

    .venv/bin/python -m lab.training.fit_posterior [--method NAME] [--every N] [--write]

Five numbers for each restitution maximise the likelihood of the counts of the reference
datasets and of bodies of other families, where the estimates are all that is known
before the drops.
"""

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from ros_pose_stats.core.records import Array
from ros_pose_stats.core.statistics.fitted_prior import FITTED_METHOD
from ros_pose_stats.core.statistics.prior import PriorFit

from .posterior_samples import RESTITUTIONS, Sample, samples

MODULE = (
    Path(__file__).resolve().parents[2]
    / "ros_pose_stats/core/statistics/fitted_prior.py"
)

BEGIN = (0.0, math.log(0.5), math.log(5e-4), math.log(0.03), math.log(0.25))
MOST = (0.0, 0.0, 0.0, math.log(0.9))
STEP = 0.4
"""Size of the first simplex of the search, in logarithms."""
CLOSE = 0.01
LIKELY = 0.1
"""Tolerances at which the search ends: of the logarithms, and of the log likelihood."""


def log_likelihood(samples: Sequence[Sample], fit: PriorFit) -> float:
    """Log likelihood of the counts of some bodies."""
    return sum(sample.prior(fit).log_evidence(sample.count) for sample in samples)


def fit_prior(samples: Sequence[Sample]) -> PriorFit:
    """Fit the numbers to bodies at one restitution."""
    begin = np.array(BEGIN)
    simplex = np.vstack((begin, begin + STEP * np.eye(len(begin))))
    optimum = minimize(
        lambda x: -log_likelihood(samples, _fit(x)),
        begin,
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "xatol": CLOSE, "fatol": LIKELY},
    )
    return _fit(optimum.x)


def fit_priors(samples: Sequence[Sample]) -> dict[float, PriorFit]:
    """Fit the numbers of each restitution."""
    return {
        rho: fit_prior([sample for sample in samples if sample.restitution == rho])
        for rho in RESTITUTIONS
    }


def _fit(x: Array) -> PriorFit:
    """Numbers of a point of the search; all but the first are logarithms, at most
    `MOST`.
    """
    return PriorFit(
        float(x[0]),
        *(
            math.exp(min(value, limit))
            for value, limit in zip(x[1:], MOST, strict=True)
        ),
    )


def source(method: str, fits: dict[float, PriorFit]) -> str:
    """Source of the module that holds the numbers."""
    rows = "\n".join(
        f"    ({', '.join(f'{value:.4g}' for value in fit[: len(BEGIN)])}),"
        for fit in fits.values()
    )
    return TEXT.format(method, tuple(fits), rows)


TEXT = '''"""Numbers of the prior, written by `python -m lab.training.fit_posterior`."""

FITTED_METHOD = "{}"  # the estimator that they belong to
FITTED_AT = {}  # restitutions of the rows below

FITTED = (
{}
)
"""`PriorFit.center`, `spread`, `overrated`, `rare_below` and `unsure_share` at each."""
'''


def main() -> None:
    """Fit, and print or write."""
    parser = argparse.ArgumentParser(
        prog="lab.training.fit_posterior", description=__doc__.partition("\n")[0]
    )
    parser.add_argument(
        "--method",
        default=FITTED_METHOD,
        help="the estimator to combine with drops (default: %(default)s)",
    )
    parser.add_argument(
        "--every",
        type=int,
        default=12,
        help="take every so many bodies; the "
        "others are left to judge by (default: %(default)s)",
    )
    parser.add_argument("--write", action="store_true", help=f"write {MODULE.name}")
    options = parser.parse_args()
    text = source(options.method, fit_priors(samples(options.method, options.every)))
    if options.write:
        MODULE.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
