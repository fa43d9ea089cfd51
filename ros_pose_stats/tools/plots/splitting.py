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

"""The splitting graph: which poses part from which, at which height (Fig. 3C)."""

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...core.records import StablePose
from ...core.resting.splitting_graph import SAME_LEVEL, SplittingNode
from .figures import BLUE, INK, REFERENCE, in_digits, new_figure, separate

LONGEST = 8
"""Characters that name the poses of a component; a box of more would cover the next."""

UNDER = 0.45
"""Distance from the middle of its box, in ends, below which a line begins under it."""

ROOM = 0.62  # below the lowest pose, inches
TALL = 0.93  # height of the axes, as a fraction of the figure's


def splitting_figure(root: SplittingNode, poses: Sequence[StablePose]) -> Figure:
    """Draw the splitting graph of a part (Fig. 3C).

    Boxes are components of the reachable set, at the height where they fall apart;
    circles are poses. On the lines stand the transition probabilities (Eq. 8); a line
    is the thicker the more probable its component. Levels too close to be read are set
    apart.
    """
    heights = {pose.index: pose.height for pose in poses}
    top = drawn_tree(root)
    ends = [branch for branch in top.walk() if not branch.parts]
    levels = place_branches(top, ends, heights)
    width = max(5.2, 0.58 * len(ends) + 1.0)
    height = 2.6 + 0.34 * len(levels)
    figure = new_figure(width, height)
    axes = figure.add_axes((0.78 / width, 0.05, 1.0 - 0.83 / width, TALL))
    for branch in top.walk():
        _draw_lines(axes, branch)
    for branch in top.walk():
        _draw_node(axes, branch, heights)
    _label_levels(
        axes,
        levels,
        len(ends),
        min(branch.y for branch in ends),
        ROOM / (TALL * height),
    )
    return figure


def _draw_lines(axes: Axes, branch: "Branch") -> None:
    """A bar at the level, and lines down with their transition probabilities."""
    if not branch.parts:
        return
    axes.plot(
        [branch.parts[0].x, branch.parts[-1].x],
        [branch.y, branch.y],
        color=BLUE,
        linewidth=1.0,
        zorder=1,
    )
    for part in branch.parts:
        axes.plot(
            [part.x, part.x],
            [branch.y, part.y],
            color=BLUE,
            zorder=1,
            linewidth=_thickness(part),
            solid_capstyle="butt",
        )
        probability = branch.node.probability
        share = part.node.probability / probability if probability > 0.0 else 0.0
        side = -1.0 if part is branch.parts[0] or part.x < branch.x else 1.0
        right_by = 2.5 + 0.5 * _thickness(part)
        down_by = 3.0
        if abs(part.x - branch.x) < UNDER:  # clear of the box
            right_by = 9.5
            down_by = 9.5
        axes.annotate(
            _share(share),
            (part.x, branch.y),
            xytext=(side * right_by, -down_by),
            textcoords="offset points",
            ha="right" if side < 0.0 else "left",
            va="top",
            fontsize=8.5,
            color=INK,
            zorder=4,
        )


def _thickness(branch: "Branch") -> float:
    return 0.8 + 5.0 * branch.node.probability


def _share(share: float) -> str:
    """A probability with two decimals; 0 and 1 only where they are exact."""
    if 0.0 < share < 0.005:
        return "<.01"
    return ">.99" if 0.995 <= share < 1.0 else f"{share:.2f}".replace("0.", ".", 1)


def _draw_node(axes: Axes, branch: "Branch", heights: dict[int, float]) -> None:
    poses = branch.node.poses
    numbers = " ".join(map(str, poses))
    text = numbers if len(numbers) <= LONGEST else f"{len(poses)} poses"
    box: dict[str, Any] = {"edgecolor": BLUE}
    if branch.parts:
        box |= {"facecolor": "#eef3f8", "boxstyle": "square,pad=0.28"}
    else:
        shape = "circle" if len(poses) == 1 else "round"
        box |= {"facecolor": "white", "linewidth": 1.3, "boxstyle": f"{shape},pad=0.25"}
    axes.annotate(
        text,
        (branch.x, branch.y),
        ha="center",
        va="center",
        fontsize=8.5 if branch.parts else 9,
        color=INK,
        zorder=3,
        bbox=box,
    )
    if branch.parts:
        return
    lowest = 1e3 * heights[lowest_pose(branch, heights)]
    axes.annotate(
        f"{100.0 * branch.node.probability:.1f} %\n{in_digits(lowest, 3)} mm",
        (branch.x, branch.y),
        xytext=(0.0, -12.0),
        textcoords="offset points",
        ha="center",
        va="top",
        fontsize=7.2,
        color=REFERENCE,
        linespacing=1.15,
    )


def _label_levels(
    axes: Axes,
    levels: Sequence[tuple[float, float]],
    ends: int,
    lowest: float,
    room: float,
) -> None:
    """Ticks at the levels of the splits, in mm; `room`: a share of the height."""
    axes.set_xlim(-0.8, ends - 0.3)
    top = max([position for _, position in levels], default=lowest) + 0.1
    axes.set_ylim(lowest - room / (1.0 - room) * (top - lowest), top)
    axes.set_xticks([])
    # As few digits as tell the levels from each other.
    for digits in range(4, 10):
        labels = [in_digits(1e3 * level, digits) for level, _ in levels]
        if len(set(labels)) == len(labels):
            break
    axes.set_yticks([position for _, position in levels], labels, fontsize=8.5)
    axes.set_ylabel("energy / weight where it splits, mm", fontsize=9.5)
    axes.spines[["top", "right", "bottom"]].set_visible(False)
    axes.grid(axis="y", color="#e8e8e8", linewidth=0.6, zorder=0)
    axes.set_axisbelow(True)


MOST = 16
"""Most ends of the graph; components that would have more are drawn as one end."""

GAP = 0.14
DROP = 0.11
"""Least distance of two levels on the page, and of a level and a pose below it, as
fractions of the graph's height."""


@dataclass
class Branch:
    """A component as it is drawn."""

    node: SplittingNode
    # what it falls apart into; empty at the lower end
    parts: "list[Branch]" = field(default_factory=list)
    x: float = 0.0  # where it is drawn
    y: float = 0.0

    def walk(self) -> "Iterator[Branch]":
        """Go through the branch and all below it, from the top down."""
        yield self
        for part in self.parts:
            yield from part.walk()


def drawn_tree(root: SplittingNode) -> Branch:
    """Merge tied splits, and open the graph from the top where it is most probable."""
    top = Branch(root)
    order = count()
    heap = [(-root.probability, next(order), top)]
    ends = 1
    while heap:
        _, _, branch = heapq.heappop(heap)
        parts = _parts(branch.node)
        if not parts or ends + len(parts) - 1 > MOST:
            continue
        ends += len(parts) - 1
        branch.parts = [Branch(part) for part in parts]
        for part in branch.parts:
            heapq.heappush(heap, (-part.node.probability, next(order), part))
    return top


def _parts(node: SplittingNode) -> list[SplittingNode]:
    """What a component falls into at its level, ties taken together."""
    lowest = (node.level or 0.0) * (1.0 - SAME_LEVEL)
    parts: list[SplittingNode] = []
    nodes = list(reversed(node.parts))
    while nodes:
        part = nodes.pop()
        if part.level is not None and part.level >= lowest:
            nodes.extend(reversed(part.parts))
        else:
            parts.append(part)
    return parts


def place_branches(
    top: Branch, ends: Sequence[Branch], heights: dict[int, float]
) -> list[tuple[float, float]]:
    """Set where each branch is drawn; return the levels (metres) and their heights."""
    branches = [branch for branch in top.walk() if branch.parts]
    for number, end in enumerate(ends):
        end.x = number
    for branch in reversed(branches):
        branch.x = 0.5 * (branch.parts[0].x + branch.parts[-1].x)

    levels = np.unique(
        [branch.node.level for branch in branches if branch.node.level is not None]
    )
    levels = levels[np.diff(levels, append=np.inf) > SAME_LEVEL * levels]
    lowest = min(heights.values())
    scale = max(levels.max(initial=lowest) - lowest, 1e-12)
    shares = (levels - lowest) / scale
    positions = separate(shares, min(GAP, 0.9 / (len(levels) + 1)), low=DROP)
    page = (np.append(0.0, shares), np.append(0.0, positions))

    def lower(branch: Branch, ceiling: float) -> None:
        level = branch.node.level
        if not branch.parts:
            level = heights[lowest_pose(branch, heights)]
        height = np.interp(((level or 0.0) - lowest) / scale, *page)
        branch.y = height if branch.parts else min(height, ceiling - DROP)
        for part in branch.parts:
            lower(part, branch.y)

    lower(top, np.inf)
    return list(zip(levels.tolist(), positions.tolist(), strict=True))


def lowest_pose(branch: Branch, heights: dict[int, float]) -> int:
    """Pose of a branch whose centre of mass lies lowest."""
    return min(branch.node.poses, key=heights.__getitem__)
