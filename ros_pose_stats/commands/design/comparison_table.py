"""The table of a comparison of variants."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...design.comparison import SHOWN, Comparison, VariantComparison
from ...design.describe import describe_matching, describe_verdict, letter, name_warnings
from ...statistics.feeding import Bounded
from ...text import Column, columns, interval, percent, ranges, several

MOST_ROWS = 40


def comparison_table(found: Comparison) -> str:
    """All variants beside the first one, as text."""
    lines = [f"{letter(place)} {one.part_id}: {several(len(one.poses), 'stable pose')}, "
             f"radius {1e3 * one.radius:.4g} mm" for place, one in enumerate(found.found)]
    lines += [found.found[0].scene,
              f"{found.drops} drops of each from the same starts, {found.found[0].unsettled} "
              f"unsettled, seed {found.seed}"]
    for one in found.variants:
        lines += ["", *_variant(found, one)]
    warnings = [f"{whose}: {line}" for line, whose in name_warnings(found).items()]
    return "\n".join([*lines, *(["", *warnings] if warnings else []), "",
                      "in brackets and as ranges: 90 % intervals, each by itself; verdicts hold "
                      "for all poses together",
                      f"computed in {found.seconds:.1f} s"])


def _variant(found: Comparison, one: VariantComparison) -> list[str]:
    other = letter(one.second)
    heads = [Column("A"), Column(other), Column("A", "%"), Column("90 %", "%"),
             Column(other, "%"), Column("90 %", "%"), Column(f"{other} - A", "points"),
             Column("90 %", "points"), Column("difference", "in the model", left=True),
             Column("difference", "on a plate", left=True)]
    rows = [[_numbers(pose.poses.first), _numbers(pose.poses.second),
             *_share(pose.share.first, pose.poses.first),
             *_share(pose.share.second, pose.poses.second),
             _points(pose.share.difference.value),
             f"{_points(pose.share.difference.low)} to {_points(pose.share.difference.high)}",
             _verdict(pose.share.in_model), _verdict(pose.share.on_plate)]
            for pose in one.poses[:MOST_ROWS]]
    lines = [*one.warnings, describe_verdict(found, one), *describe_matching(one), "",
             *columns(heads, rows)]
    hidden = one.poses[MOST_ROWS:]
    if hidden:
        lines.append(f"... and {several(len(hidden), 'more row')}; --json lists all")
    return [*lines, *_feeder(one)]


def _feeder(one: VariantComparison) -> list[str]:
    feeder = one.feeder
    if feeder is None:
        return []
    heads = [Column("a feeder that accepts", left=True), Column("gets, %"),
             Column("passes a part")]
    rows = [[f"{name} {_numbers(poses)}",
             f"{percent(way.accepted.value)} ({interval(way.accepted.low, way.accepted.high)})",
             _bounded(way.passes)]
            for name, poses, way in zip(("A", letter(one.second)), feeder.poses, feeder.feeding,
                                        strict=True)]
    lines = ["", *columns(heads, rows)]
    if feeder.lost:
        lines.append(f"wanted poses of A without a partner in {letter(one.second)}: "
                     f"{ranges(feeder.lost)}")
    return lines


def _points(fraction: float) -> str:
    """A signed difference; a dash where it is not known."""
    if math.isnan(fraction):
        return "-"
    return f"{round(100.0 * fraction, 2) + 0.0:+.2f}"


def _verdict(word: str) -> str:
    return "shown" if word == SHOWN else word


def _numbers(poses: Sequence[int]) -> str:
    return ranges(poses) or "no partner"


def _share(share: Bounded, poses: Sequence[int]) -> tuple[str, str]:
    if not poses:
        return "-", "-"
    return percent(share.value), interval(share.low, share.high)


def _bounded(number: Bounded) -> str:
    return f"{number.value:.4g} ({number.low:.4g} - {number.high:.4g})"
