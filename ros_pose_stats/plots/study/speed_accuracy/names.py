"""What is written into a panel of the chart: the names of its points, series and front."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from ...spacing import apart
from ..cost import INK, REFERENCE
from .labels import Array, Labels, Spot, around
from .points import ESTIMATORS, KINDS, ChartPoint, series_of

SIZE = 9.5
"""Of the print, points (1/72 inch)."""

LINE = 13.0
"""Distance of the names of the estimators, points."""

LEADER = 26.0
"""Length of the shortest line from the column of these names to a marker, points."""

FRONT = "nothing is both\nfaster and more exact"


def write_names(axes: Axes, points: Sequence[ChartPoint], corners: tuple[Array, Array]) -> None:
    """Name the points, the series and the front.

    Parameters
    ----------
    axes : Axes
        With its final limits and place; everything but the names is drawn.
    points : sequence of ChartPoint
    corners : (seconds, error)
        Of the front's stair, as it is drawn.
    """
    labels = Labels(axes)
    bottom = axes.get_ylim()[0]
    for point in points:
        labels.keep_clear([point.seconds], [100.0 * point.error], 5.0)
        labels.keep_clear([point.seconds] * 2, np.maximum([100.0 * point.low, 100.0 * point.high],
                                                          bottom), 1.5)
    labels.keep_clear(*corners, 1.0)
    for _, members in series_of(points):
        labels.keep_clear([point.seconds for point in members],
                          [100.0 * point.error for point in members], 1.0)
    _name_estimators(labels, [point for point in points if point.kind in ESTIMATORS],
                     points)
    for point in points:
        if point.kind not in ESTIMATORS:
            labels.put(point.name, around(_place(point)), fontsize=SIZE, color=INK)
    for name, members in series_of(points):
        labels.put(name, _along(members), fontsize=SIZE + 0.5, fontweight="bold",
                   color=KINDS[members[0].kind].ink)
    labels.put(FRONT, _below(*corners), joined=False, fontsize=SIZE, color=REFERENCE,
               style="italic")


def _place(point: ChartPoint) -> tuple[float, float]:
    return point.seconds, 100.0 * point.error


def _name_estimators(labels: Labels, estimators: Sequence[ChartPoint],
                     points: Sequence[ChartPoint]) -> None:
    """A column of names left of all points, as near to the heights of the markers as they fit."""
    if not estimators:
        return
    shown = labels.axes.transData
    heights = np.array([shown.transform(_place(point))[1] for point in estimators]) / labels.unit
    box = labels.axes.bbox
    column = min(shown.transform(_place(point))[0] for point in points) / labels.unit - LEADER
    placed = apart(heights, LINE, box.y0 / labels.unit + 0.6 * LINE,
                   box.y1 / labels.unit - 0.6 * LINE)
    for point, height in zip(estimators, placed, strict=True):
        anchor = shown.transform(_place(point)) / labels.unit
        spot = Spot(_place(point), (column - anchor[0], height - anchor[1]), "right", "center")
        ink = KINDS["paper"].ink if point.kind == "paper" else INK
        labels.put_at(point.name, spot, fontsize=SIZE, color=ink,
                      fontweight="normal" if point.kind == "paper" else "bold")


def _along(members: Sequence[ChartPoint]) -> list[Spot]:
    """Spots beside the middles of a series' lines, or around its only point."""
    if len(members) == 1:
        return around(_place(members[0]))
    ends = np.log([_place(point) for point in members])
    middles = np.exp(0.5 * (ends[:-1] + ends[1:]))
    return [spot for x, y in middles for spot in around((float(x), float(y)), (5.0, 9.0, 15.0))]


def _below(seconds: Array, error: Array) -> list[Spot]:
    """Spots under the treads of the stair, close ones and the longest treads first."""
    logs = np.log(seconds)
    treads = sorted(zip(logs[1::2], logs[2::2], error[1::2], strict=True),
                    key=lambda tread: tread[0] - tread[1])
    return [Spot((float(np.exp(begin + share * (end - begin))), float(height)), (0.0, -drop),
                 "center", "top")
            for drops in ((4.0, 8.0, 12.0), (20.0, 30.0, 40.0, 50.0, 60.0))
            for begin, end, height in treads
            for share in (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9, 0.0)
            for drop in drops]
