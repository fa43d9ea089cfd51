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

"""Names in a panel of the chart, each at the place where it covers the least."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.path import Path
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike

from ros_pose_stats.core.records import Array
from ros_pose_stats.tools.plots.figures import INK, REFERENCE, separate

from .points import ESTIMATORS, KINDS, ChartPoint, series_of

SIZE = 9.5
"""Of the print, points (1/72 inch)."""

LINE = 13.0
"""Distance of the names of the estimators, points."""

LEADER = 26.0
"""Length of the shortest line from the column of these names to a marker, points."""

REACH = (5.0, 7.0, 10.0, 14.0, 20.0, 28.0)
"""Distances of a text from what it names, points; the nearest free one is taken."""

SIDES = {
    (1, 0): ("left", "center"),
    (-1, 0): ("right", "center"),
    (0, 1): ("center", "bottom"),
    (0, -1): ("center", "top"),
    (1, 1): ("left", "bottom"),
    (1, -1): ("left", "top"),
    (-1, 1): ("right", "bottom"),
    (-1, -1): ("right", "top"),
}
"""Sides on which a text may lie, with its alignment there."""

CLEAR = 3.0
"""Room between a text and marks, points."""

MARK = 30.0
TEXT = 300.0
OUTSIDE = 1000.0
"""Costs of covering a hundredth of a line, or a text, or of leaving the axes; a point
of distance costs 1.
"""


def write_names(
    axes: Axes, points: Sequence[ChartPoint], corners: tuple[Array, Array]
) -> None:
    """Name the points and the series.

    Parameters
    ----------
    axes : Axes
        With its final limits and place; everything but the names is drawn.
    points : sequence of ChartPoint
    corners : (seconds, error)
        Of the front's stair, as it is drawn.
    """
    bottom = axes.get_ylim()[0]
    bars = [
        [
            (point.seconds, max(100.0 * error, bottom))
            for error in (point.low, point.error, point.high)
        ]
        for point in points
    ]
    series = {name: _positions(members) for name, members in series_of(points)}
    labels = Labels(axes, [np.column_stack(corners), *bars, *series.values()])
    labels.name_estimators([point for point in points if point.kind in ESTIMATORS])
    inks = {}
    for point in points:
        if point.kind not in ESTIMATORS:
            weight = "bold" if point.kind == "default" else "normal"
            ink = KINDS[point.kind].ink
            labels.place_text(
                point.name, _positions([point]), color=ink, fontweight=weight
            )
            inks[point.series] = ink
    for name, line in series.items():
        middles = np.sqrt(line[1:] * line[:-1]) if len(line) > 1 else line
        labels.place_text(name, middles, color=inks[name], fontweight="bold")


def _positions(points: Sequence[ChartPoint]) -> Array:
    return np.array([(point.seconds, 100.0 * point.error) for point in points])


class Labels:
    """The marks of the axes, and the texts that were put between them.

    Parameters
    ----------
    axes : Axes
        With its final limits and place in the figure, which must not be laid out anew.
    lines : sequence of (k, 2) arrays
        What texts keep off, data coordinates.
    """

    def __init__(self, axes: Axes, lines: Sequence[ArrayLike]) -> None:
        self.axes = axes
        self.unit = axes.figure.dpi / 72.0
        pixels = [Path(axes.transData.transform(line)) for line in lines]
        self.marks = np.vstack([path.interpolated(100).vertices for path in pixels])
        self.texts: list[Bbox] = []

    def place_text(self, text: str, anchors: Array, **style: Any) -> None:
        """Write a text beside one of the anchors (k, 2), data coordinates, where it
        covers the least.
        """
        note = self._write(text, anchors[0], **style)
        spots = [
            (anchor, reach, side)
            for reach in REACH
            for anchor in anchors
            for side in SIDES
        ]
        self._move(note, *min(spots, key=lambda spot: self._cost(note, *spot)))
        self.texts.append(note.get_window_extent())

    def name_estimators(self, estimators: Sequence[ChartPoint]) -> None:
        """A column of names left of all marks, as near to the heights of the markers as
        they fit, and joined to these by lines.
        """
        if not estimators:
            return
        anchors = _positions(estimators)
        pixels = self.axes.transData.transform(anchors)
        bounds = self.axes.bbox.padded(-0.6 * LINE * self.unit)
        heights = separate(
            pixels[:, 1] / self.unit, LINE, bounds.y0 / self.unit, bounds.y1 / self.unit
        )
        column = self.marks[:, 0].min() / self.unit - LEADER
        offsets = np.column_stack((np.full(len(heights), column), heights))
        for point, anchor, offset in zip(
            estimators, anchors, offsets - pixels / self.unit, strict=True
        ):
            note = self._write(
                point.name,
                anchor,
                xytext=offset,
                ha="right",
                va="center",
                color=KINDS["paper"].ink if point.kind == "paper" else INK,
                fontweight="normal" if point.kind == "paper" else "bold",
                arrowprops={
                    "arrowstyle": "-",
                    "color": REFERENCE,
                    "linewidth": 0.7,
                    "shrinkA": 0.0,
                    "shrinkB": 3.0,
                    "relpos": (1.0, 0.5),
                },
            )
            self.texts.append(note.get_window_extent())

    def _write(self, text: str, anchor: Array, **style: Any) -> Annotation:
        return self.axes.annotate(
            text,
            (anchor[0], anchor[1]),
            textcoords="offset points",
            fontsize=SIZE,
            annotation_clip=False,
            **{"xytext": (0.0, 0.0), **style},
        )

    def _move(
        self, note: Annotation, anchor: Array, reach: float, side: tuple[int, int]
    ) -> None:
        ha, va = SIDES[side]
        note.set(ha=ha, va=va, position=reach * np.array(side))
        note.xy = tuple(anchor)

    def _cost(
        self, note: Annotation, anchor: Array, reach: float, side: tuple[int, int]
    ) -> float:
        self._move(note, anchor, reach, side)
        box = note.get_window_extent().padded(CLEAR * self.unit)
        cost = reach * float(np.hypot(*side)) + MARK * box.count_contains(self.marks)
        if self.axes.bbox.count_contains(box.corners()) < 4:
            cost += OUTSIDE
        return cost + TEXT * (box.count_overlaps(self.texts) if self.texts else 0)
