"""Tables of statistics that commands print."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

import numpy as np

from ..records import Part, PoseStatistics, StablePose
from ..text import Column, columns, degrees, interval, millimetres, several

BAR = 12
MOST_ROWS = 40
UNKNOWN = "-"
"""How columns write a value that is not known."""


def report(part: Part, found: PoseStatistics) -> str:
    """Report of one method's answer: a row for each pose, most probable first.

    The columns and their order are the same for every method; a column is left out where the
    method has no values for it.
    """
    return "\n".join([_heading(part, found), "", *_method(found), "", *_pose_table(found),
                      *_rest(found.poses), *_remarks([found])])


def comparison(part: Part, found: Sequence[PoseStatistics]) -> str:
    """Table of all methods' answers side by side; poses are in the order of the last method."""
    leading = found[-1]
    by_index = [{pose.index: pose.probability for pose in each.poses} for each in found]
    lines = [_heading(part, leading), "",
             f"probability in %, ordered by {leading.method}, "
             f"cluster tolerance {leading.cluster_tolerance:g}", "",
             f"{'pose':>4} {'group':>5} " + "".join(f"{each.method:>9}" for each in found)
             + f" {'height':>9} {'barrier':>9} {'margin':>7}",
             f"{'':>4} {'':>5} " + " " * (9 * len(found)) + f" {'mm':>9} {'mm':>9} {'deg':>7}"]
    for pose in leading.poses[:MOST_ROWS]:
        values = "".join(f"{100.0 * each[pose.index]:>9.2f}" for each in by_index)
        lines.append(f"{pose.index:>4} {pose.group:>5} {values} {_length(pose.height)} "
                     f"{_length(pose.barrier)} {math.degrees(pose.margin):>7.2f}")
    return "\n".join([*lines, *_rest(leading.poses), *_remarks(found)])


def _method(found: PoseStatistics) -> list[str]:
    """Lines about the method and its settings."""
    named = f"method {found.method}, cluster tolerance {found.cluster_tolerance:g}, "
    if not found.drops:
        return [f"{named}expected error {100.0 * found.expected_error:.1f} points against drops "
                f"at restitution {found.restitution:g}"]
    return [f"{found.drops} drops, {found.unsettled} unsettled, seed {found.seed}, restitution "
            f"{found.restitution:g}, released {_metric(found.drop_height)} above the plate,",
            f"{named}expected error {100.0 * found.expected_error:.2f} points"]


def _pose_table(found: PoseStatistics) -> list[str]:
    poses = found.poses[:MOST_ROWS]
    table = [
        (Column("pose"), [str(pose.index) for pose in poses]),
        (Column("group"), [str(pose.group) for pose in poses]),
        (Column("probability", left=True), [
            f"{_percent(pose.probability)} {_bar(pose.probability)}" for pose in poses]),
        (Column("90 % interval", "%"), [
            interval(pose.probability_low, pose.probability_high) for pose in poses]),
        (Column("drops"), [str(pose.count) if found.drops else UNKNOWN for pose in poses]),
        (Column("height", "mm"), [millimetres(pose.height) for pose in poses]),
        (Column("barrier", "mm"), [millimetres(pose.barrier) for pose in poses]),
        (Column("margin", "deg"), [degrees(pose.margin) for pose in poses]),
        (Column("down", left=True), [_direction(pose) for pose in poses])]
    # The column of barriers stays for a single pose, which has none.
    shown = [(head, cells) for head, cells in table
             if head.title == "barrier" or set(cells) != {UNKNOWN}]
    return columns([head for head, _ in shown],
                   list(zip(*(cells for _, cells in shown), strict=True)))


def _heading(part: Part, found: PoseStatistics) -> str:
    size = np.ptp(part.surface_vertices, axis=0) * 1e3
    center = np.round(part.center_of_mass / found.radius, 6) * found.radius * 1e3 + 0.0
    extents = " x ".join(f"{x:.4g}" for x in size)
    return (f"{part.part_id}: {several(len(found.poses), 'stable pose')}, "
            f"{len(part.triangles)} triangles, {extents} mm\n"
            f"centre of mass ({', '.join(f'{x:.4g}' for x in center)}) mm, "
            f"radius {found.radius * 1e3:.4g} mm")


def _metric(metres: float) -> str:
    return f"{metres * 1e3:.4g} mm" if metres < 1.0 else f"{metres:.4g} m"


def _percent(probability: float) -> str:
    return f"{100.0 * probability:6.2f}%"


def _bar(probability: float) -> str:
    encoding = (sys.stdout.encoding or "ascii").lower()
    full, partial = ("█", "▏▎▍▌▋▊▉") if encoding.startswith("utf") else ("#", "")
    steps = len(partial) + 1
    probability = 0.0 if math.isnan(probability) else probability
    filled = round(probability * BAR * steps)
    tail = partial[filled % steps - 1] if filled % steps else ""
    return (full * (filled // steps) + tail).ljust(BAR)


def _length(metres: float) -> str:
    return f"{'-':>9}" if math.isinf(metres) else f"{metres * 1e3:>9.4g}"


def _direction(pose: StablePose) -> str:
    return "(" + ", ".join(f"{x + 0.0:+.3f}" for x in np.round(pose.down, 3)) + ")"


def _rest(poses: Sequence[StablePose]) -> list[str]:
    hidden = poses[MOST_ROWS:]
    if not hidden:
        return []
    together = sum(pose.probability for pose in hidden)
    return [f"... and {len(hidden)} more poses, {_percent(together).strip()} together; "
            "--json lists all"]


def _remarks(found: Sequence[PoseStatistics]) -> list[str]:
    warnings = list(dict.fromkeys(line for each in found for line in each.warnings))
    seconds = sum(each.seconds for each in found)
    duration = f"{seconds * 1e3:.3g} ms" if seconds < 1.0 else f"{seconds:.1f} s"
    choices = list(dict.fromkeys(each.choice for each in found if each.choice))
    return ["", *choices, *warnings, f"computed in {duration}"]
