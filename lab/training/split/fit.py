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

"""The fit of `split`: its loss is the likelihood of the counts and the paper's square
error.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats.core.estimators.fitted import SPLIT_FILE, SplitFit, TanhNetwork
from ros_pose_stats.core.estimators.split import component_bases
from ros_pose_stats.core.records import Array

from ..network_fit import (
    coefficient_count,
    descend,
    network_gradient,
    network_of,
    pack_networks,
    random_coefficients,
    undo_scaling,
)
from .counting import HIGHEST_DROP, HIGHEST_RESTITUTION, LOWEST_DROP
from .gradient import loss_gradient
from .samples import FIT_SEED, Sample
from .table import Table, make_table

Single = NDArray[np.float32]

SQUARE = 3.0
"""Weight of the square error beside the negative log likelihood of a drop."""

BATCH = 512
"""Samples of a step."""

UNITS = (60, 20)
RIDGE = 2e-6
EPOCHS = 100
"""Hidden units of both networks, ridge, and how often the fit uses each sample."""

STARTS = 2
"""Number of fits, from random starts, whose logarithms are averaged."""

HELD_SELDOM = -4.0
"""First value of the constant in the weights of holding faces."""


class Batch(NamedTuple):
    """Some samples."""

    table: Table
    inputs: Single  # (3 K, 26) standardised
    bases: Single  # (2, 3 K), as from `component_bases`, with the first constant


def fit_all(samples: Sequence[Sample], workers: int) -> tuple[SplitFit, ...]:
    """Make the fits that the package ships."""
    table = make_table([sample for sample in samples if sample.seed == FIT_SEED])
    with ThreadPoolExecutor(workers) as pool:
        return tuple(
            pool.map(
                lambda start: fit_networks(table, UNITS, RIDGE, EPOCHS, start),
                range(STARTS),
            )
        )


def fit_networks(
    table: Table, units: tuple[int, int], ridge: float, epochs: int, seed: int = 0
) -> SplitFit:
    """Fit both networks to the samples of a table.

    Parameters
    ----------
    table : Table
    units : tuple of int
        Hidden units of either network.
    ridge : float
        Weight of the squares of all coefficients, for standardised inputs, in the mean
        loss.
    epochs : int
        Number of times that each sample is used.
    seed : int
        Of the first coefficients, and of the order of the samples.
    """
    mean = table.inputs.mean(axis=0)
    scale = table.inputs.std(axis=0) + np.float32(1e-6)
    columns = table.inputs.shape[1]
    draw = np.random.default_rng(seed)
    begin = np.concatenate(
        [random_coefficients(columns, hidden, draw) for hidden in units]
    )
    order = draw.permutation(table.splits.shape[0])
    batches = [
        _batch(table.some(order[first : first + BATCH]), mean, scale)
        for first in range(0, order.shape[0], BATCH)
    ]
    coefficients = descend(
        lambda batch, values: batch_gradient(values, batches[batch], units, ridge),
        begin,
        len(batches),
        epochs,
        draw,
    )
    left, held = (
        undo_scaling(part, mean, scale) for part in _parts(coefficients, columns, units)
    )
    return SplitFit(left, held._replace(bias=held.bias + HELD_SELDOM))


def write_weights(fits: Sequence[SplitFit], file: Path = SPLIT_FILE) -> None:
    """Write the weights to the file that the estimator reads, or to another one.

    The highest restitution and the drop heights (radii) of the data are written too.
    """
    np.savez(
        file,
        **pack_networks([fit.area_network for fit in fits], "left_"),
        **pack_networks([fit.holding_network for fit in fits], "held_"),
        scenes=np.array((HIGHEST_RESTITUTION, LOWEST_DROP, HIGHEST_DROP)),
    )


def _parts(
    values: Array, columns: int, units: tuple[int, int]
) -> tuple[TanhNetwork, TanhNetwork]:
    first = coefficient_count(columns, units[0])
    return (
        network_of(values[:first], columns, units[0]),
        network_of(values[first:], columns, units[1]),
    )


def _batch(table: Table, mean: Single, scale: Single) -> Batch:
    bases = np.stack(component_bases(table.inputs)).astype(np.float32)
    bases[1] += np.float32(HELD_SELDOM)
    return Batch(table, (table.inputs - mean) / scale, bases)


def batch_gradient(
    values: Array, batch: Batch, units: tuple[int, int], ridge: float
) -> Array:
    """Gradient of the mean loss of a batch with the ridge, by the coefficients of both
    networks.

    The networks are computed in single precision.
    """
    inputs = batch.inputs
    parts = [
        TanhNetwork(
            np.float32(part.bias), *(weights.astype(np.float32) for weights in part[1:])
        )
        for part in _parts(values, inputs.shape[1], units)
    ]
    hidden = [
        np.tanh(inputs @ part.hidden_weights + part.hidden_bias) for part in parts
    ]
    logarithms = np.stack(
        [
            base + part.bias + inputs @ part.skip + tangents @ part.output_weights
            for base, part, tangents in zip(batch.bases, parts, hidden, strict=True)
        ]
    )
    whole = np.logaddexp(*logarithms)
    slopes = loss_gradient(whole.astype(float), batch.table, SQUARE)
    slopes_single = slopes.astype(np.float32) * np.exp(logarithms - whole)
    slope = np.concatenate(
        [
            network_gradient(part, tangents, inputs, of_part)
            for part, tangents, of_part in zip(
                parts, hidden, slopes_single, strict=True
            )
        ]
    )
    return slope + 2.0 * ridge * values
