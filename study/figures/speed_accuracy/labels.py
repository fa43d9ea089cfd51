"""Texts in a panel of the chart, each at the place where it covers the least."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike, NDArray

from ros_pose_stats.tools.plots.figures import INK, REFERENCE, separate

from .points import ESTIMATORS, KINDS, ChartPoint, series_of

Array = NDArray[np.float64]

CLEAR = 1.5
"""Free room around a text, points."""

FAR = 16.0
"""Distance, in points, from which on a thin line joins a label and its point."""

MARK = 30.0
TEXT = 300.0
OUTSIDE = 1000.0
"""Costs of covering a mark or a text, or of leaving the axes; a point of distance costs
1.
"""


class Spot(NamedTuple):
    """A place for a label.

    Attributes
    ----------
    anchor : (float, float)
        Place that the label names, data coordinates.
    offset : (float, float)
        Distance from there, points.
    ha, va : str
        Which side of the text lies there.
    """

    anchor: tuple[float, float]
    offset: tuple[float, float]
    ha: str
    va: str


def spots_around(
    anchor: tuple[float, float], reach: Iterable[float] = (7.0, 14.0, 22.0, 34.0, 48.0)
) -> list[Spot]:
    """Spots on all sides of an anchor, `reach` points away."""
    sides = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))
    horizontal = {1: "left", 0: "center", -1: "right"}
    vertical = {1: "bottom", 0: "center", -1: "top"}
    return [
        Spot(anchor, (step * x, step * y), horizontal[x], vertical[y])
        for step in reach
        for x, y in sides
    ]


class Labels:
    """The occupied places of the axes, and the texts that were put between them.

    Parameters
    ----------
    axes : Axes
        With its final limits and place in the figure, which must not be laid out anew.
    """

    def __init__(self, axes: Axes) -> None:
        self.axes = axes
        self.unit = axes.figure.dpi / 72.0
        self.occupied: list[tuple[Array, float]] = []

    def keep_clear(self, seconds: ArrayLike, error: ArrayLike, radius: float) -> None:
        """Keep texts off a line, data coordinates, by a radius in points."""
        corners = self.axes.transData.transform(np.column_stack((seconds, error)))
        for begin, end in zip(
            corners, corners[1:] if len(corners) > 1 else corners, strict=False
        ):
            steps = int(np.hypot(*(end - begin)) / (3.0 * self.unit)) + 2
            middle = np.linspace(begin, end, steps)
            reach = radius * self.unit
            self._occupy(np.hstack((middle - reach, middle + reach)), MARK)

    def place_text(
        self, text: str, spots: Iterable[Spot], *, joined: bool = True, **style: Any
    ) -> Annotation:
        """Write a text at the spot where it covers the least, the first of equally good
        ones.
        """
        size = self._size(text, style)
        best = min(spots, key=lambda spot: self._cost(self._box(size, spot), spot))
        return self.write_text(text, best, joined=joined, **style)

    def write_text(
        self, text: str, spot: Spot, *, joined: bool = True, **style: Any
    ) -> Annotation:
        """Write a text at one spot; no later one will be put onto it.

        A distant text is joined to its place by a line, if wanted.
        """
        if joined and np.hypot(*spot.offset) >= FAR:
            style["arrowprops"] = {
                "arrowstyle": "-",
                "color": REFERENCE,
                "linewidth": 0.7,
                "shrinkA": 0.0,
                "shrinkB": 3.0,
                "relpos": _text_side(spot),
            }
        note = self.axes.annotate(
            text,
            spot.anchor,
            xytext=spot.offset,
            textcoords="offset points",
            ha=spot.ha,
            va=spot.va,
            annotation_clip=False,
            **style,
        )
        box = self._box(self._size(text, style), spot)
        self._occupy(np.array([[box.x0, box.y0, box.x1, box.y1]]), TEXT)
        return note

    def _occupy(self, boxes: Array, cost: float) -> None:
        self.occupied.append((boxes, cost))

    def _size(self, text: str, style: dict[str, Any]) -> tuple[float, float]:
        """Width and height of a text, pixels."""
        plain = {name: value for name, value in style.items() if name != "arrowprops"}
        probe = self.axes.text(0.0, 0.0, text, transform=None, **plain)
        box = probe.get_window_extent()
        probe.remove()
        return box.width, box.height

    def _box(self, size: tuple[float, float], spot: Spot) -> Bbox:
        """Where a text of that size will lie, pixels."""
        position = self.axes.transData.transform(spot.anchor) + np.multiply(
            spot.offset, self.unit
        )
        low = position - np.multiply(size, _text_side(spot))
        box: Bbox = Bbox.from_bounds(low[0], low[1], *size).padded(CLEAR * self.unit)
        return box

    def _cost(self, box: Bbox, spot: Spot) -> float:
        inside = self.axes.bbox
        cost = float(np.hypot(*spot.offset))
        if not (
            inside.x0 <= box.x0
            and box.x1 <= inside.x1
            and inside.y0 <= box.y0
            and box.y1 <= inside.y1
        ):
            cost += OUTSIDE
        for boxes, weight in self.occupied:
            covered = (
                (boxes[:, 0] < box.x1)
                & (boxes[:, 2] > box.x0)
                & (boxes[:, 1] < box.y1)
                & (boxes[:, 3] > box.y0)
            )
            cost += weight * np.count_nonzero(covered)
        return cost


def _text_side(spot: Spot) -> tuple[float, float]:
    """The side of the text that lies at the spot, as a fraction of its width and
    height.
    """
    return (
        {"left": 0.0, "center": 0.5, "right": 1.0}[spot.ha],
        {"bottom": 0.0, "center": 0.5, "top": 1.0}[spot.va],
    )


SIZE = 9.5
"""Of the print, points (1/72 inch)."""

LINE = 13.0
"""Distance of the names of the estimators, points."""

LEADER = 26.0
"""Length of the shortest line from the column of these names to a marker, points."""

FRONT = "nothing is both\nfaster and more exact"


def write_names(
    axes: Axes, points: Sequence[ChartPoint], corners: tuple[Array, Array]
) -> None:
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
        labels.keep_clear(
            [point.seconds] * 2,
            np.maximum([100.0 * point.low, 100.0 * point.high], bottom),
            1.5,
        )
    labels.keep_clear(*corners, 1.0)
    for _, members in series_of(points):
        labels.keep_clear(
            [point.seconds for point in members],
            [100.0 * point.error for point in members],
            1.0,
        )
    _name_estimators(
        labels, [point for point in points if point.kind in ESTIMATORS], points
    )
    for point in points:
        if point.kind not in ESTIMATORS:
            labels.place_text(
                point.name, spots_around(_position(point)), fontsize=SIZE, color=INK
            )
    for name, members in series_of(points):
        labels.place_text(
            name,
            _spots_along(members),
            fontsize=SIZE + 0.5,
            fontweight="bold",
            color=KINDS[members[0].kind].ink,
        )
    labels.place_text(
        FRONT,
        _spots_below(*corners),
        joined=False,
        fontsize=SIZE,
        color=REFERENCE,
        style="italic",
    )


def _position(point: ChartPoint) -> tuple[float, float]:
    return point.seconds, 100.0 * point.error


def _name_estimators(
    labels: Labels, estimators: Sequence[ChartPoint], points: Sequence[ChartPoint]
) -> None:
    """A column of names left of all points, as near to the heights of the markers as
    they fit.
    """
    if not estimators:
        return
    transform = labels.axes.transData
    heights = (
        np.array([transform.transform(_position(point))[1] for point in estimators])
        / labels.unit
    )
    box = labels.axes.bbox
    column = (
        min(transform.transform(_position(point))[0] for point in points) / labels.unit
        - LEADER
    )
    placed = separate(
        heights,
        LINE,
        box.y0 / labels.unit + 0.6 * LINE,
        box.y1 / labels.unit - 0.6 * LINE,
    )
    for point, height in zip(estimators, placed, strict=True):
        anchor = transform.transform(_position(point)) / labels.unit
        spot = Spot(
            _position(point),
            (column - anchor[0], height - anchor[1]),
            "right",
            "center",
        )
        ink = KINDS["paper"].ink if point.kind == "paper" else INK
        labels.write_text(
            point.name,
            spot,
            fontsize=SIZE,
            color=ink,
            fontweight="normal" if point.kind == "paper" else "bold",
        )


def _spots_along(members: Sequence[ChartPoint]) -> list[Spot]:
    """Spots beside the middles of a series' lines, or around its only point."""
    if len(members) == 1:
        return spots_around(_position(members[0]))
    ends = np.log([_position(point) for point in members])
    middles = np.exp(0.5 * (ends[:-1] + ends[1:]))
    return [
        spot
        for x, y in middles
        for spot in spots_around((float(x), float(y)), (5.0, 9.0, 15.0))
    ]


def _spots_below(seconds: Array, error: Array) -> list[Spot]:
    """Spots under the treads of the stair, close ones and the longest treads first."""
    logs = np.log(seconds)
    treads = sorted(
        zip(logs[1::2], logs[2::2], error[1::2], strict=True),
        key=lambda tread: tread[0] - tread[1],
    )
    return [
        Spot(
            (float(np.exp(begin + share * (end - begin))), float(height)),
            (0.0, -drop),
            "center",
            "top",
        )
        for drops in ((4.0, 8.0, 12.0), (20.0, 30.0, 40.0, 50.0, 60.0))
        for begin, end, height in treads
        for share in (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9, 0.0)
        for drop in drops
    ]
