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

"""The fit of the expected errors.

The mean square error of each sample of `lab/training/split/samples.npz`, over its scale
(`estimators.fitted`), is a smooth function of inputs that need no simulation
(`estimators.fitted`). A square error scatters by about its own size. So the likelihood
is that of an exponential distribution, whose mean is the expected square error plus the
noise of the drops. How much parts of which the same is expected scatter beyond that is
one number a method, fitted with the means as they are.
"""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from scipy.optimize import minimize, minimize_scalar
from scipy.special import gammaln, logsumexp

from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.estimators.expected import scatter_mixture
from ros_pose_stats.core.estimators.fitted import ERROR_FILE, ErrorFit
from ros_pose_stats.core.records import Array
from study.dataset import shipped_datasets
from study.estimates import restings, scene_estimates, square_errors

from ..network_fit import (
    network_gradient,
    network_of,
    pack_networks,
    random_coefficients,
    round_to_digits,
    undo_scaling,
)
from .samples import ErrorSamples

RESTITUTIONS = (0.2, 0.5, 0.8)
UNITS = 6
RIDGE = 1e-4
ITERATIONS = 400
"""Hidden units; ridge (weight of the squares of all coefficients, for standardised
inputs).
"""

WIDTHS = (0.01, 3.0)
"""Of the scatter."""

LEAST = 1e-12
"""Square error of which the logarithm is taken, at least."""

CONSTANT = 1e-6
"""Standard deviation of an input below which it counts as constant."""


def usual_errors() -> dict[str, Array]:
    """Root mean square error (3,) over the parts of the reference datasets, by
    method.
    """
    squares: dict[tuple[str, float], list[Array]] = {}
    for dataset in shipped_datasets():
        estimates = scene_estimates(dataset, restings(dataset))
        for rho in RESTITUTIONS:
            for name, values in estimates[rho].items():
                squares.setdefault((name, rho), []).append(
                    square_errors(values, dataset.simulated(rho))
                )
    return {
        name: np.sqrt(
            [np.concatenate(squares[name, rho]).mean() for rho in RESTITUTIONS]
        )
        for name in ESTIMATORS
    }


def fit_errors(samples: ErrorSamples, seed: int = 0) -> ErrorFit:
    """Fit the function of the inputs with the largest likelihood."""
    lowest = samples.inputs.min(axis=0)
    highest = samples.inputs.max(axis=0)
    mean = samples.inputs.mean(axis=0)
    scale = samples.inputs.std(axis=0)
    scale[scale < CONSTANT] = 1.0  # such as the distance of MEAE from itself
    inputs = (samples.inputs - mean) / scale
    columns = inputs.shape[1]
    begin = random_coefficients(columns, UNITS, np.random.default_rng(seed))
    begin[0] = math.log(samples.square.mean() / samples.scale.mean())
    coefficients = minimize(
        _objective,
        begin,
        (samples, inputs),
        "L-BFGS-B",
        True,
        options={"maxiter": ITERATIONS, "maxcor": 20},
    ).x
    network = undo_scaling(network_of(coefficients, columns, UNITS), mean, scale)
    return ErrorFit(
        lowest,
        highest,
        network,
        _fit_scatter(samples, samples.scale * np.exp(network(samples.inputs))),
    )


def _fit_scatter(samples: ErrorSamples, expected: Array) -> float:
    """Standard deviation of the logarithm of the square errors over the expected ones
    (U,).
    """
    half = 0.5 * samples.freedom

    def unlikely(width: float) -> float:
        weight, factor = scatter_mixture(width)
        whole = np.square(factor)[:, None] * expected + samples.noise
        likely = (
            half * np.log(half / whole)
            - half * samples.square / whole
            + (half - 1.0) * np.log(np.maximum(samples.square, LEAST))
            - gammaln(half)
        )
        return -float(logsumexp(likely, axis=0, b=weight[:, None]).mean())

    return float(minimize_scalar(unlikely, bounds=WIDTHS, method="bounded").x)


def write_weights(
    fits: Mapping[str, ErrorFit], usual: Mapping[str, Array], file: Path = ERROR_FILE
) -> None:
    """Write the weights to the file that the estimators read, or to another one."""
    all_fits = list(fits.values())
    np.savez(
        file,
        method=np.array(list(fits)),
        lowest=round_to_digits(np.array([fit.lowest for fit in all_fits])),
        highest=round_to_digits(np.array([fit.highest for fit in all_fits])),
        scatter=np.round([fit.scatter for fit in all_fits], 3),
        **pack_networks([fit.network for fit in all_fits], ""),
        usual_at=np.array(RESTITUTIONS),
        usual=np.round([usual[name] for name in fits], 3),
    )


def _objective(
    values: Array, samples: ErrorSamples, inputs: Array
) -> tuple[float, Array]:
    """Mean negative log likelihood with the ridge, and its gradient."""
    network = network_of(values, inputs.shape[1], UNITS)
    tangents = np.tanh(inputs @ network.hidden_weights + network.hidden_bias)
    square = samples.scale * np.exp(
        network.bias + inputs @ network.skip + tangents @ network.output_weights
    )
    whole = square + samples.noise
    loss = np.mean(np.log(whole) + samples.square / whole)
    slopes_of_loss = (1.0 - samples.square / whole) * square / whole / len(square)
    slopes = np.asarray(
        network_gradient(network, tangents, inputs, slopes_of_loss), dtype=float
    )
    return float(loss + RIDGE * (values @ values)), slopes + 2.0 * RIDGE * values
