"""A table of poses in text: what statistics print, and commands of several methods."""

import math
import sys
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ...base import text
from ...base.text import Column
from .part import Array
from .poses import PoseGroup

BAR = 12  # characters of a full bar
MOST_INDICES = 20  # characters for the indices of the poses of a row
UNKNOWN = "-"  # how columns write a value that is not known
ROLLING = "  * rolls in this pose; the tilt to topple holds across its axis only"


class FilledColumn(NamedTuple):
    """A column of a table with its cells."""

    head: Column
    cells: list[str]


def pose_table(
    groups: Sequence[PoseGroup], probabilities: Iterable[FilledColumn]
) -> list[str]:
    """Lines about groups of poses, of which the first `MOST_POSES` are listed.

    `probabilities`: columns for the middle of the table, of the listed groups. Columns
    in which nothing is known are left out.
    """
    listed = groups[: text.MOST_POSES]
    poses = [group.first for group in listed]
    are_joined = any(group.size > 1 for group in listed)
    sizes = [str(group.size) if are_joined else UNKNOWN for group in listed]
    rolls = any(pose.rolls for pose in poses)

    columns = [
        FilledColumn(
            Column("poses" if are_joined else "pose"),
            [_indices(group) for group in listed],
        ),
        FilledColumn(Column("number"), sizes),
        FilledColumn(Column("group"), [str(pose.group) for pose in poses]),
        *probabilities,
        FilledColumn(
            Column("height", "mm"), [text.millimetres(pose.height) for pose in poses]
        ),
        FilledColumn(
            Column("barrier", "mm"),
            [text.millimetres(group.barrier) for group in listed],
        ),
        FilledColumn(
            Column("topple", "deg"), [_topple(group, rolls) for group in listed]
        ),
        FilledColumn(
            Column("down", left=True), [_direction(pose.down) for pose in poses]
        ),
    ]
    # The column of barriers stays for a single pose, which has none.
    columns = [
        column
        for column in columns
        if column.head.title == "barrier" or set(column.cells) != {UNKNOWN}
    ]
    lines = text.columns(
        [column.head for column in columns],
        list(zip(*(column.cells for column in columns), strict=True)),
    )

    unlisted = groups[text.MOST_POSES :]
    if unlisted:
        poses_unlisted = sum(group.size for group in unlisted)
        share = _percent(sum(group.probability for group in unlisted)).strip()
        lines.append(
            f"... and {text.several(poses_unlisted, 'more pose')}, "
            f"{share} together; --json lists all"
        )
    if rolls:
        lines.append(ROLLING)
    return lines


def probability_columns(
    groups: Sequence[PoseGroup], *, with_counts: bool
) -> list[FilledColumn]:
    """Probabilities of the listed groups, their intervals, and counts."""
    listed = groups[: text.MOST_POSES]
    return [
        FilledColumn(
            Column("probability", left=True),
            [
                f"{_percent(group.probability)} {_bar(group.probability)}"
                for group in listed
            ],
        ),
        FilledColumn(
            Column("90 % interval", "%"),
            [
                text.interval(group.probability_low, group.probability_high)
                for group in listed
            ],
        ),
        FilledColumn(
            Column("drops"),
            [str(group.count) if with_counts else UNKNOWN for group in listed],
        ),
    ]


def _indices(group: PoseGroup) -> str:
    """Indices of the poses; the last ones are left out of a long list."""
    indices = text.ranges(group.indices)
    if len(indices) <= MOST_INDICES:
        return indices
    return f"{indices[:MOST_INDICES].rpartition(',')[0]}, ..."


def _topple(group: PoseGroup, is_marked: bool) -> str:
    """The tilt that topples a group, with room for the mark of those that roll."""
    tilt = text.degrees(group.margin)
    if not is_marked:
        return tilt
    return tilt + (" *" if group.first.rolls else "  ")


def _direction(vector: Array) -> str:
    return "(" + ", ".join(f"{x + 0.0:+.3f}" for x in np.round(vector, 3)) + ")"


def _percent(probability: float) -> str:
    return f"{100.0 * probability:6.2f}%"


def _bar(probability: float) -> str:
    """A bar in the characters that the terminal can write."""
    # The encoding is None where standard output is closed.
    encoding = (getattr(sys.stdout, "encoding", None) or "ascii").lower()
    probability = 0.0 if math.isnan(probability) else probability
    # No tie of 1/8 or 1/12, which rounding would decide.
    eighths = round(8 * BAR * probability)
    if encoding.startswith("utf"):
        bar = "█" * (eighths // 8) + " ▏▎▍▌▋▊▉"[eighths % 8]
    else:
        bar = "#" * ((eighths + 4) // 8)
    return bar.ljust(BAR)[:BAR]
