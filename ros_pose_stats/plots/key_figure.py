"""One picture of a part's poses: the part in each of them, probabilities, and splitting graph."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..records import Part, PoseStatistics
from ..resting.splitting_graph import SplittingNode, with_shares
from .files import RASTER
from .poses import poses_figure
from .shares import name_method, shares_figure
from .splitting import splitting_figure
from .style import INK

Picture = NDArray[np.uint8]

LEAST = 4.2
"""Least width, and height, of the bars, inches."""

TITLE = 0.34
"""Height of a title, inches."""


def key_picture(part: Part, found: Sequence[PoseStatistics], root: SplittingNode) -> Picture:
    """Draw a part's poses, their probabilities and the splitting graph as one picture.

    `found`: of that part, by one or two methods; the first is that of the pictures and the graph.
    Returns (height, width, 3) uint8: at the top the part and the scene; then the poses on the
    plate, most probable first; below on the left probabilities with 90 % intervals, on the right
    the splitting graph with the same probabilities, where there is more than one pose.
    """
    first = found[0]
    above = poses_figure(part, first)
    across, _ = above.get_size_inches()
    graph = (splitting_figure(with_shares(root, first.poses), first.poses)
             if root.level is not None else None)
    beside, high = graph.get_size_inches() if graph is not None else (0.0, 0.0)
    bars = shares_figure(found, (max(LEAST, across - beside), max(LEAST, high)))
    below = [_titled("Probability of each pose", bars)]
    if graph is not None:
        below.append(_titled("Splitting graph: the sets of poses as energy is lost, "
                             f"{name_method(first)}", graph))
    return _stacked([_pixels(above), _side_by_side(below)])


def _titled(words: str, figure: Figure) -> Picture:
    """A figure under a title."""
    title = Figure(figsize=(float(figure.get_figwidth()), TITLE))
    title.text(0.5, 0.5, words, fontsize=10.5, color=INK, ha="center", va="center")
    return _stacked([_pixels(title), _pixels(figure)])


def _pixels(figure: Figure) -> Picture:
    """Pixels of a figure."""
    figure.set_dpi(RASTER)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # type: ignore[no-untyped-call]
    shown = canvas.buffer_rgba()  # type: ignore[no-untyped-call]
    return np.asarray(shown)[:, :, :3].copy()


def _stacked(pictures: Sequence[Picture]) -> Picture:
    """Join pictures one below the other, the narrower ones centred on white."""
    wide = max(one.shape[1] for one in pictures)
    return np.concatenate([_widened(one, wide) for one in pictures])


def _side_by_side(pictures: Sequence[Picture]) -> Picture:
    turned = _stacked([one.transpose(1, 0, 2) for one in pictures])
    return np.ascontiguousarray(turned.transpose(1, 0, 2))


def _widened(picture: Picture, wide: int) -> Picture:
    spare = wide - picture.shape[1]
    return np.pad(picture, ((0, 0), (spare // 2, spare - spare // 2), (0, 0)),
                  constant_values=255)
