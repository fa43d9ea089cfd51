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

"""What fits of networks share: coefficients in one array, their gradient, and their
storage.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from ros_pose_stats.core.estimators.fitted import TanhNetwork
from ros_pose_stats.core.records import Array

Floats = NDArray[np.floating]

RATE = 0.01
WARMING = 0.05
"""Highest rate of `descend`, and the share of its steps over which it rises to that."""

KEPT_MEAN = 0.9
KEPT_SQUARE = 0.999
LEAST_SLOPE = 1e-8
"""Constants of Adam as its authors give them."""


def coefficient_count(columns: int, units: int) -> int:
    """Number of coefficients of a network with so many inputs and hidden units."""
    return 1 + columns + (columns + 2) * units


def random_coefficients(columns: int, units: int, draw: Generator) -> Array:
    """Coefficients of a network whose value is 0, with random weights of the hidden
    units.
    """
    return np.concatenate(
        (
            [0.0],
            np.zeros(columns),
            draw.normal(size=columns * units) / math.sqrt(columns),
            0.1 * draw.normal(size=units),
            np.zeros(units),
        )
    )


def network_of(values: Array, columns: int, units: int) -> TanhNetwork:
    """Network with the coefficients of one array."""
    end = 1 + columns * (1 + units)
    return TanhNetwork(
        float(values[0]),
        values[1 : 1 + columns],
        values[1 + columns : end].reshape(columns, units),
        values[end : end + units],
        values[end + units :],
    )


def network_gradient(
    network: TanhNetwork, tangents: Floats, inputs: Floats, output_gradient: Floats
) -> Floats:
    """Gradient by the coefficients, from the gradient `back` (n,) by the values of rows
    (n, K).
    """
    inner = (1.0 - tangents * tangents) * np.outer(
        output_gradient, network.output_weights
    )
    return np.concatenate(
        (
            [output_gradient.sum()],
            inputs.T @ output_gradient,
            (inputs.T @ inner).ravel(),
            inner.sum(axis=0),
            tangents.T @ output_gradient,
        )
    )


def descend(
    slopes: Callable[[int, Array], Array],
    values: Array,
    batches: int,
    epochs: int,
    draw: Generator,
) -> Array:
    """Minimise a mean over batches of samples by Adam (Kingma and Ba, 2015).

    The rate rises over the first steps, then falls to 0 like a half wave of a cosine.

    Parameters
    ----------
    slopes : callable
        Gradient (n,) of the loss of one batch, from its number and the values.
    values : (n,) array
        To begin from.
    batches : int
    epochs : int
        Number of times that each batch is used.
    draw : Generator
        For the order of the batches.
    """
    coefficients = values.copy()
    mean = np.zeros_like(values)
    square = np.zeros_like(values)
    order = np.concatenate([draw.permutation(batches) for _ in range(epochs)])
    for step, batch in enumerate(order.tolist(), 1):
        progress = step / len(order)
        rate = (
            RATE
            * min(progress / WARMING, 1.0)
            * 0.5
            * (1.0 + math.cos(math.pi * progress))
        )
        slope = slopes(batch, coefficients)
        mean += (1.0 - KEPT_MEAN) * (slope - mean)
        square += (1.0 - KEPT_SQUARE) * (slope * slope - square)
        coefficients -= (
            rate
            * mean
            / (1.0 - KEPT_MEAN**step)
            / (np.sqrt(square / (1.0 - KEPT_SQUARE**step)) + LEAST_SLOPE)
        )
    return coefficients


def undo_scaling(network: TanhNetwork, mean: Floats, scale: Floats) -> TanhNetwork:
    """The same function of x as a network, from a network of (x - mean) / scale."""
    skip = network.skip / scale
    hidden = network.hidden_weights / scale[:, None]
    return TanhNetwork(
        network.bias - float(mean @ skip),
        skip,
        hidden,
        network.hidden_bias - mean @ hidden,
        network.output_weights,
    )


def pack_networks(networks: Sequence[TanhNetwork], prefix: str) -> dict[str, Array]:
    """Networks of one size as arrays to store, rounded to five digits: the data give no
    more.
    """
    columns = zip(TanhNetwork._fields, zip(*networks, strict=True), strict=True)
    return {
        prefix + name: round_to_digits(np.array(column)) for name, column in columns
    }


def round_to_digits(values: Array) -> Array:
    """Values rounded to five significant digits, each the float nearest to that
    decimal.
    """
    rounded = [float(f"{value:.5g}") for value in np.ravel(values)]
    return np.reshape(rounded, np.shape(values))
