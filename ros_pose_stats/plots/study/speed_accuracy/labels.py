"""Labels beside points, each where it covers the least."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike, NDArray

from ..cost import REFERENCE

Array = NDArray[np.float64]

CLEAR = 1.5
"""Points kept free around a text."""

FAR = 16.0
"""Points from which on a thin line joins a label with what it names."""

MARK, TEXT, OUTSIDE = 30.0, 300.0, 1000.0
"""What it costs to cover a mark or a text, or to leave the axes; a point of distance costs 1."""


class Spot(NamedTuple):
    """A place for a label.

    Attributes
    ----------
    anchor : (float, float)
        What it names, data coordinates.
    offset : (float, float)
        From there, points.
    ha, va : str
        Which side of the text lies there.
    """

    anchor: tuple[float, float]
    offset: tuple[float, float]
    ha: str
    va: str


def around(anchor: tuple[float, float], reach: Iterable[float] = (7.0, 14.0, 22.0, 34.0, 48.0)
           ) -> list[Spot]:
    """Spots on all sides of an anchor, `reach` points away."""
    sides = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))
    across = {1: "left", 0: "center", -1: "right"}
    upward = {1: "bottom", 0: "center", -1: "top"}
    return [Spot(anchor, (step * x, step * y), across[x], upward[y])
            for step in reach for x, y in sides]


class Labels:
    """What is taken on the axes, and the texts that were put beside it.

    Parameters
    ----------
    axes : Axes
        With its final limits and place in the figure, which must not be laid out anew.
    """

    def __init__(self, axes: Axes) -> None:
        self.axes = axes
        self.unit = axes.figure.dpi / 72.0
        self.taken: list[tuple[Array, float]] = []

    def keep_clear(self, seconds: ArrayLike, error: ArrayLike, radius: float) -> None:
        """Take the surroundings of a line, data coordinates and a radius in points."""
        corners = self.axes.transData.transform(np.column_stack((seconds, error)))
        for begin, end in zip(corners, corners[1:] if len(corners) > 1 else corners, strict=False):
            steps = int(np.hypot(*(end - begin)) / (3.0 * self.unit)) + 2
            middle = np.linspace(begin, end, steps)
            reach = radius * self.unit
            self._take(np.hstack((middle - reach, middle + reach)), MARK)

    def put(self, text: str, spots: Iterable[Spot], *, joined: bool = True,
            **style: Any) -> Annotation:
        """Write a text at the spot where it covers the least, the first of equally good ones."""
        size = self._size(text, style)
        best = min(spots, key=lambda spot: self._cost(self._box(size, spot), spot))
        return self.put_at(text, best, joined=joined, **style)

    def put_at(self, text: str, spot: Spot, *, joined: bool = True, **style: Any) -> Annotation:
        """Write a text at one spot; no later one will be put onto it.

        From afar a line joins it with what it names, if wanted.
        """
        if joined and np.hypot(*spot.offset) >= FAR:
            style["arrowprops"] = {"arrowstyle": "-", "color": REFERENCE, "linewidth": 0.7,
                                   "shrinkA": 0.0, "shrinkB": 3.0, "relpos": _nearest(spot)}
        note = self.axes.annotate(text, spot.anchor, xytext=spot.offset,
                                  textcoords="offset points", ha=spot.ha, va=spot.va,
                                  annotation_clip=False, **style)
        box = self._box(self._size(text, style), spot)
        self._take(np.array([[box.x0, box.y0, box.x1, box.y1]]), TEXT)
        return note

    def _take(self, boxes: Array, cost: float) -> None:
        self.taken.append((boxes, cost))

    def _size(self, text: str, style: dict[str, Any]) -> tuple[float, float]:
        """Width and height of a text, pixels."""
        plain = {name: value for name, value in style.items() if name != "arrowprops"}
        probe = self.axes.text(0.0, 0.0, text, transform=None, **plain)
        box = probe.get_window_extent()
        probe.remove()
        return box.width, box.height

    def _box(self, size: tuple[float, float], spot: Spot) -> Bbox:
        """Where a text of that size will lie, pixels."""
        at = self.axes.transData.transform(spot.anchor) + np.multiply(spot.offset, self.unit)
        low = at - np.multiply(size, _nearest(spot))
        box: Bbox = Bbox.from_bounds(low[0], low[1], *size).padded(CLEAR * self.unit)
        return box

    def _cost(self, box: Bbox, spot: Spot) -> float:
        inside = self.axes.bbox
        cost = float(np.hypot(*spot.offset))
        if not (inside.x0 <= box.x0 and box.x1 <= inside.x1
                and inside.y0 <= box.y0 and box.y1 <= inside.y1):
            cost += OUTSIDE
        for boxes, each in self.taken:
            covered = ((boxes[:, 0] < box.x1) & (boxes[:, 2] > box.x0)
                       & (boxes[:, 1] < box.y1) & (boxes[:, 3] > box.y0))
            cost += each * np.count_nonzero(covered)
        return cost


def _nearest(spot: Spot) -> tuple[float, float]:
    """The side of the text that lies at the spot, as a fraction of its width and height."""
    return ({"left": 0.0, "center": 0.5, "right": 1.0}[spot.ha],
            {"bottom": 0.0, "center": 0.5, "top": 1.0}[spot.va])
