"""The splitting graph laid out on a page: what is drawn of it, and where."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count

import numpy as np
from numpy.typing import NDArray

from ..resting.splitting_graph import SAME_LEVEL, SplittingNode
from .spacing import apart

MOST = 16
"""Ends of the graph; what parts farther down is drawn as one."""

GAP, DROP = 0.14, 0.11
"""Between two levels on the page, and between a level and a pose below it, as fractions of the
graph's height."""


@dataclass
class Branch:
    """A component as it is drawn.

    Attributes
    ----------
    node : SplittingNode
    parts : list of Branch
        What it falls apart into; empty at the lower end.
    x, y : float
        Where it is drawn.
    """

    node: SplittingNode
    parts: list[Branch] = field(default_factory=list)
    x: float = 0.0
    y: float = 0.0

    def walk(self) -> Iterator[Branch]:
        """Go through the branch and all below it, from the top down."""
        yield self
        for part in self.parts:
            yield from part.walk()


def drawn_tree(root: SplittingNode, most: int = MOST) -> Branch:
    """The graph with tied splits as one, opened from the top where it is most probable.

    Parameters
    ----------
    root : SplittingNode
    most : int
        Ends at most; a split into more stays closed.
    """
    top, order = Branch(root), count()
    waiting = [(-root.probability, next(order), top)]
    ends = 1
    while waiting:
        _, _, branch = heapq.heappop(waiting)
        parts = _parts(branch.node)
        if not parts or ends + len(parts) - 1 > most:
            continue
        ends += len(parts) - 1
        branch.parts = [Branch(part) for part in parts]
        for part in branch.parts:
            heapq.heappush(waiting, (-part.node.probability, next(order), part))
    return top


def _parts(node: SplittingNode) -> list[SplittingNode]:
    """What a component falls into at its level, ties taken together."""
    found: list[SplittingNode] = []
    waiting = list(reversed(node.parts))
    while waiting:
        part = waiting.pop()
        if part.level is not None and node.level is not None and (
                part.level >= node.level * (1.0 - SAME_LEVEL)):
            waiting.extend(reversed(part.parts))
        else:
            found.append(part)
    return found


def place(top: Branch, ends: Sequence[Branch],
           heights: dict[int, float]) -> list[tuple[float, float]]:
    """Set where each branch is drawn; return the levels (metres) and their places."""
    for place, end in enumerate(ends):
        end.x = float(place)
    for branch in reversed([one for one in top.walk() if one.parts]):
        branch.x = 0.5 * (branch.parts[0].x + branch.parts[-1].x)
    true = _distinct([one.node.level for one in top.walk() if one.parts])
    lowest = min(heights.values())
    scale = max(float(true[-1]) - lowest, 1e-12) if len(true) else 1.0
    share = (true - lowest) / scale
    shown = apart(share, min(GAP, 0.9 / (len(true) + 1)), low=DROP) if len(true) else share
    page = (np.append(0.0, share), np.append(0.0, shown))

    def lower(branch: Branch, above: float) -> None:
        level = branch.node.level if branch.parts else heights[lowest_pose(branch, heights)]
        height = float(np.interp((float(level or 0.0) - lowest) / scale, *page))
        branch.y = height if branch.parts else min(height, above - DROP)
        for part in branch.parts:
            lower(part, branch.y)

    lower(top, np.inf)
    return list(zip(true.tolist(), shown.tolist(), strict=True))


def _distinct(levels: Sequence[float | None]) -> NDArray[np.float64]:
    """Levels by rising value, equal ones once."""
    values = np.array(sorted({float(level) for level in levels if level is not None}))
    if not len(values):
        return values
    return np.asarray(values[np.append(np.diff(values) > SAME_LEVEL * values[1:], True)])


def lowest_pose(branch: Branch, heights: dict[int, float]) -> int:
    """Pose of a branch whose centre of mass lies lowest."""
    return min(branch.node.poses, key=heights.__getitem__)
