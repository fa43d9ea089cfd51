"""Tables of statistics."""

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...base import text as words
from ...base.text import (
    Column,
    columns,
    degrees,
    interval,
    millimetres,
    percent,
    several,
)

if TYPE_CHECKING:
    from .part import Part
    from .statistics import PoseStatistics, StablePose

Filled = tuple[Column, list[str]]

BAR = 12
MOST_NAMED = 20  # characters that name the poses of a row
ROLLS = (
    "  ",
    " *",
)  # behind the tilt to topple: of a pose that does not roll, of one that does
ROLLING = "  * rolls in this pose; the tilt to topple holds across its axis only"
UNKNOWN = "-"  # how columns write a value that is not known


@dataclass(frozen=True, eq=False)
class PoseGroup:
    """Poses that a proper rotation of the part carries into each other, or a single pose."""

    # at least one, by rising `index`. All are as high; what ties decide may differ a little
    poses: "tuple[StablePose, ...]"
    probability: float  # of all of them together
    probability_low: float  # bounds of its 90 % interval; NaN where none is known
    probability_high: float
    count: int  # drops that came to rest in any of them

    @property
    def first(self) -> "StablePose":
        """The pose of the smallest index."""
        return self.poses[0]

    @property
    def size(self) -> int:
        """Number of its poses."""
        return len(self.poses)

    @property
    def margin(self) -> float:
        """The smallest of its poses, radians."""
        return min(pose.margin for pose in self.poses)

    @property
    def barrier(self) -> float:
        """The smallest of its poses, metres."""
        return min(pose.barrier for pose in self.poses)

    @property
    def indices(self) -> tuple[int, ...]:
        """Of its poses, rising."""
        return tuple(pose.index for pose in self.poses)


def single_poses(found: "PoseStatistics") -> tuple[PoseGroup, ...]:
    """Each pose by itself, in the order of the statistics."""
    return tuple(
        PoseGroup(
            (pose,),
            pose.probability,
            pose.probability_low,
            pose.probability_high,
            pose.count,
        )
        for pose in found.poses
    )


def report(
    found: "PoseStatistics",
    rows: Sequence[PoseGroup],
    part: "Part | None" = None,
    *,
    explain: bool = False,
) -> str:
    """Report of one method's answer, most probable first; columns without values are left out.

    `explain`: whether to say why the method was chosen.
    """
    shown = rows[: words.MOST_POSES]
    shares = [
        (
            Column("probability", left=True),
            [f"{_percent(row.probability)} {_bar(row.probability)}" for row in shown],
        ),
        (
            Column("90 % interval", "%"),
            [interval(row.probability_low, row.probability_high) for row in shown],
        ),
        (
            Column("drops"),
            [str(row.count) if found.drops else UNKNOWN for row in shown],
        ),
    ]
    return "\n".join(
        [
            _heading(found, part),
            "",
            _method(found),
            "",
            *_pose_table(rows, shares),
            *(["", found.choice] if explain and found.choice else []),
            *_remarks([found]),
        ]
    )


def comparison(
    found: Sequence["PoseStatistics"], rows: Sequence[Sequence[PoseGroup]], part: "Part"
) -> str:
    """All methods' answers side by side, in the order of the last method's rows."""
    asked = next((one for one in found if math.isfinite(one.drop_height)), found[-1])
    shares = []
    for one, own in zip(found, rows, strict=True):
        there = {row.first.index: row.probability for row in own}
        shares.append(
            (
                Column(one.method),
                [
                    percent(there[row.first.index])
                    for row in rows[-1][: words.MOST_POSES]
                ],
            )
        )
    return "\n".join(
        [
            _heading(asked, part),
            "",
            f"probability in %, ordered by {found[-1].method}, "
            f"cluster tolerance {found[-1].cluster_tolerance:g}",
            "",
            *_pose_table(rows[-1], shares),
            *_remarks(found),
        ]
    )


def parts_table(found: Sequence["PoseStatistics"]) -> str:
    """A row for each part: its most probable poses, by which method, and the error."""
    if not found:
        return "no parts; send one: ros_pose_stats publish PART"
    return "\n".join(
        columns(
            [
                Column("part", left=True),
                Column("poses"),
                Column("most probable", "pose: %", left=True),
                Column("method", left=True),
                Column("drops"),
                Column("error", "points"),
            ],
            [
                (
                    one.part_id,
                    str(len(one.poses)),
                    words.most_probable(one.poses) or "forgotten",
                    one.method,
                    str(one.observed or one.drops),
                    percent(one.expected_error),
                )
                for one in found
            ],
        )
    )


def _method(found: "PoseStatistics") -> str:
    """Lines about the method and its settings."""
    named = f"method {found.method}, cluster tolerance {found.cluster_tolerance:g}, "
    if not found.drops:
        return (
            f"{named}expected error {100.0 * found.expected_error:.1f} points "
            f"(one pose: {100.0 * found.largest_error:.1f}) against drops at restitution "
            f"{found.restitution:g}"
        )
    return (
        f"{found.drops} drops, {found.unsettled} unsettled, seed {found.seed},\n"
        f"{named}expected error {100.0 * found.expected_error:.2f} points "
        f"(one pose: {100.0 * found.largest_error:.2f})"
    )


def _pose_table(rows: Sequence[PoseGroup], shares: Sequence[Filled]) -> list[str]:
    """Rows about poses, with columns of probabilities in their middle."""
    shown = rows[: words.MOST_POSES]
    poses = [row.first for row in shown]
    joined = any(row.size > 1 for row in shown)
    rolls = any(pose.rolls for pose in poses)
    table: list[Filled] = [
        (Column("poses" if joined else "pose"), [_named(row) for row in shown]),
        (Column("number"), [str(row.size) if joined else UNKNOWN for row in shown]),
        (Column("group"), [str(pose.group) for pose in poses]),
        *shares,
        (Column("height", "mm"), [millimetres(pose.height) for pose in poses]),
        (Column("barrier", "mm"), [millimetres(row.barrier) for row in shown]),
        (
            Column("topple", "deg"),
            [
                degrees(row.margin) + (ROLLS[row.first.rolls] if rolls else "")
                for row in shown
            ],
        ),
        (
            Column("down", left=True),
            [
                "(" + ", ".join(f"{x + 0.0:+.3f}" for x in np.round(pose.down, 3)) + ")"
                for pose in poses
            ],
        ),
    ]
    # The column of barriers stays for a single pose, which has none.
    kept = [
        (head, cells)
        for head, cells in table
        if head.title == "barrier" or set(cells) != {UNKNOWN}
    ]
    lines = columns(
        [head for head, _ in kept],
        list(zip(*(cells for _, cells in kept), strict=True)),
    )
    if hidden := rows[words.MOST_POSES :]:
        together = _percent(sum(row.probability for row in hidden)).strip()
        lines.append(
            f"... and {several(sum(row.size for row in hidden), 'more pose')}, "
            f"{together} together; --json lists all"
        )
    return lines + [ROLLING] * rolls


def _named(row: PoseGroup) -> str:
    """Indices of the poses; the last ones are left out of a long list."""
    text = words.ranges(row.indices)
    return (
        text
        if len(text) <= MOST_NAMED
        else f"{text[:MOST_NAMED].rpartition(',')[0]}, ..."
    )


def _heading(found: "PoseStatistics", part: "Part | None") -> str:
    groups = len({pose.group for pose in found.poses})
    alike = f" in {several(groups, 'group')}" if groups < len(found.poses) else ""
    poses = f"{several(len(found.poses), 'stable pose')}{alike}"
    if part is None:
        return f"{found.part_id}: {found.scene}\n{poses}, radius {found.radius * 1e3:.4g} mm"
    center = np.round(part.center_of_mass / found.radius, 6) * found.radius * 1e3 + 0.0
    extents = " x ".join(
        f"{x:.4g}" for x in np.ptp(part.surface_vertices, axis=0) * 1e3
    )
    return (
        f"{part.part_id}: {found.scene}\n"
        f"{poses}, {len(part.triangles)} triangles, {extents} mm\n"
        f"centre of mass ({', '.join(f'{x:.4g}' for x in center)}) mm, "
        f"radius {found.radius * 1e3:.4g} mm"
    )


def _percent(probability: float) -> str:
    return f"{100.0 * probability:6.2f}%"


def _bar(probability: float) -> str:
    encoding = (
        getattr(sys.stdout, "encoding", None) or "ascii"
    ).lower()  # None: closed
    probability = 0.0 if math.isnan(probability) else probability
    eighths = round(
        8 * BAR * probability
    )  # no tie of 1/8 or 1/12, which rounding would decide
    bar = (
        "█" * (eighths // 8) + " ▏▎▍▌▋▊▉"[eighths % 8]
        if encoding.startswith("utf")
        else "#" * ((eighths + 4) // 8)
    )
    return bar.ljust(BAR)[:BAR]


def _remarks(found: Sequence["PoseStatistics"]) -> list[str]:
    warnings = list(dict.fromkeys(line for each in found for line in each.warnings))
    seconds = sum(each.seconds for each in found)
    duration = f"{seconds * 1e3:.3g} ms" if seconds < 1.0 else f"{seconds:.1f} s"
    notes = dict.fromkeys(f"note {line}" for each in found for line in each.notes)
    return ["", *warnings, *notes, f"computed in {duration}"]
