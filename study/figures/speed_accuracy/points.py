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

"""Points, panels and kinds of the chart, their checks, and the Pareto front."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ros_pose_stats.base.methods import METHODS
from ros_pose_stats.base.text import listed
from ros_pose_stats.core.records import Array
from ros_pose_stats.core.statistics.fitted_prior import FITTED_METHOD


class Kind(NamedTuple):
    """How points of a kind are drawn.

    Attributes
    ----------
    colour, ink, marker : str
        One of Okabe and Ito's colours, a darker one for text, and a marker of its own,
        so that nobody needs to see colours.
    label : str
        In the key; see `key_label` for estimators.
    size : float
        Of the marker, points.
    """

    colour: str
    ink: str
    marker: str
    label: str
    size: float = 6.5


COMBINED = next(method.title for method in METHODS if method.name == FITTED_METHOD)
"""Title of the estimate that `hybrid` combines with drops."""

KINDS = {
    "paper": Kind("#A9C4D6", "#767676", "o", "estimator of the paper or before it"),
    "estimator": Kind("#0072B2", "#00537F", "*", "estimator", 11.0),
    "default": Kind("#1a1a1a", "#1a1a1a", "P", "default answer (auto)", 9.0),
    "hybrid": Kind("#CC79A7", "#8F4B74", "D", f"{COMBINED} and n drops (hybrid)"),
    "simulation": Kind("#D55E00", "#A34800", "s", "n drops"),
    "outside": Kind("#009E73", "#006B4E", "^", "other software"),
}

ESTIMATORS = ("paper", "estimator")
"""Kinds whose names stand in a column; they form no series."""


class ChartPoint(NamedTuple):
    """One way to get the probabilities.

    Attributes
    ----------
    name : str
        Written beside it; within a series what tells its points apart, such as "n =
        100".
    kind : str
        "paper" (faded), "estimator", "default", "hybrid", "simulation" or "outside".
    seconds : float
        Time of a part on one core, above 0.
    error : float
        As a fraction of 1, above 0.
    low, high : float
        Bounds of the error as fractions of 1, low <= high. A bar that begins at 0 or
        below is drawn from the end of the axis.
    series : str or None
        Points of one series are joined, and its name is written once. Estimators and
        the default answer have none.
    """

    name: str
    kind: str
    seconds: float
    error: float
    low: float
    high: float
    series: str | None = None


class ChartPanel(NamedTuple):
    """A size of part.

    Attributes
    ----------
    title : str
        Such as "200 vertices".
    points : sequence of ChartPoint
        At least one.
    """

    title: str
    points: Sequence[ChartPoint]


def key_label(kind: str, points: Sequence[ChartPoint]) -> str:
    """Label of a kind in the key; estimators newer than the paper are named by their
    titles.
    """
    if kind != "estimator":
        return KINDS[kind].label
    titles = list(dict.fromkeys(point.name for point in points if point.kind == kind))
    return f"{listed(titles)} {KINDS[kind].label}{'s' if len(titles) > 1 else ''}"


def series_of(points: Sequence[ChartPoint]) -> list[tuple[str, list[ChartPoint]]]:
    """Names of the series with their points, the fastest first."""
    names = dict.fromkeys(point.series for point in points if point.series is not None)
    return [
        (
            name,
            sorted(
                (point for point in points if point.series == name),
                key=lambda point: point.seconds,
            ),
        )
        for name in names
    ]


def pareto_front(points: Sequence[ChartPoint]) -> list[int]:
    """Find the points than which no other is both faster and more exact.

    An error of 0 is lost in the noise of the reference, and does not show that a point
    is better than others: such points are left out.

    Parameters
    ----------
    points : sequence of ChartPoint
        With `seconds` and `error` that are not NaN.

    Returns
    -------
    list of int
        Places in `points`, the fastest first and of equally fast ones the least exact
        first, so that the errors never rise.
    """
    order = sorted(
        (k for k, point in enumerate(points) if point.error > 0.0),
        key=lambda k: (points[k].seconds, -points[k].error),
    )
    front: list[int] = []
    faster = np.inf
    smallest = np.inf
    latest = -np.inf  # smallest error before this time and up to it
    for row in order:
        if points[row].seconds > latest:
            faster = smallest
            latest = points[row].seconds
        if points[row].error <= faster:
            front.append(row)
        smallest = min(smallest, points[row].error)
    return front


def stair(
    points: Sequence[ChartPoint], slowest: float, worst: float
) -> tuple[Array, Array]:
    """Corners of the stair below and left of which there is no point.

    Parameters
    ----------
    points : sequence of ChartPoint
        As for `pareto_front`, at least one.
    slowest, worst : float
        Where the line ends to the right and at the top, in the units of the points.

    Returns
    -------
    seconds, error : (2 k + 1,) arrays
        From the top over the k points of the front to the right.
    """
    front = [points[row] for row in pareto_front(points)]
    seconds = np.repeat([point.seconds for point in front], 2)
    error = np.repeat([point.error for point in front], 2)
    return np.append(seconds, (slowest,)), np.concatenate(((worst,), error))
