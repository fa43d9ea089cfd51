"""Tables of what changes of a part do."""

from __future__ import annotations

import math

from ...design.describe import (
    CONTRADICTED,
    JUDGED,
    describe_order,
    describe_time,
    name_feature,
    name_step,
    suggested_steps,
)
from ...design.effects import Effect, Sensitivity
from ...design.suggest import Suggestion
from ...statistics.feeding import Bounded
from ...text import Column, columns, name_poses, several

MOST_ROWS = 30


def sensitivity_table(found: Sensitivity) -> list[str]:
    """Lines: the share as it is, the effects, the greatest first, and the checks."""
    space, shown = found.space, found.effects[:MOST_ROWS]
    joined = any(len(effect.alike) > 1 for effect in shown)
    heads = [Column("change", left=True), *([Column("alike")] if joined else []),
             Column("effect"), Column("error"), Column("", left=True)]
    rows = []
    for one in shown:
        scale = 0.1 if one.feature.is_length else 1.0
        rows.append([name_feature(space, one.number), *([str(len(one.alike))] if joined else []),
                     f"{scale * one.slope:+.2f}", f"{scale * one.error:.2f}",
                     f"points per {'mm' if one.feature.is_length else '%'}"])
    hidden = len(found.effects) - len(shown)
    lines = [f"{space.part.part_id}: wanted {name_poses(found.wanted)}: "
             f"{_bounded(found.accepted)} by {found.method}, in brackets 90 % intervals",
             f"released {found.scene.drop_height:.3g} m above a frictionless plate, restitution "
             f"{found.scene.restitution:g}", "", describe_order(found),
             *columns(heads, rows)]
    if hidden:
        lines.append(f"... and {several(hidden, 'smaller effect')}; --json lists all")
    return [*lines, *_checks(found), "", *found.warnings, f"computed in {found.seconds:.1f} s",
            JUDGED]


def _checks(found: Sensitivity) -> list[str]:
    """The changes that were dropped, and those that lose a wanted pose."""
    checked = sorted((one for one in found.effects if one.check is not None),
                     key=lambda one: -one.change)
    if not checked:
        return ["", "no change was checked by drops"]
    heads = [Column("step", left=True), Column("by estimate", "points"),
             Column("by drops", "points"), Column("90 % interval", "points"),
             Column("", left=True)]
    rows = [[name_step(found.space, one.number, one.step), f"{100.0 * one.change:+.1f}",
             *_by_drops(one), _remark(one)] for one in checked]
    ended = describe_time(found)
    return ["", f"the best of these, {found.drops} drops before and after from the same starts, "
            f"seed {found.seed}", *columns(heads, rows), *([ended] if ended else [])]


def _by_drops(one: Effect) -> tuple[str, str]:
    check = one.check
    if check is None or math.isnan(check.value):
        return "-", "-"
    return f"{100.0 * check.value:+.1f}", f"{100.0 * check.low:+.1f} to {100.0 * check.high:+.1f}"


def _remark(one: Effect) -> str:
    told = [CONTRADICTED] if one.contradicted else []
    if one.lost:
        told.append(f"{name_poses(one.lost)} {'is' if len(one.lost) == 1 else 'are'} gone")
    return ", ".join(told)


def suggestion_table(found: Suggestion) -> list[str]:
    """Lines: the steps, and what they gain by estimate and by drops."""
    steps = suggested_steps(found)
    if not steps:
        return [f"suggestion: no change within {1e3 * found.within:g} mm raises the estimate"]
    gain = found.gain
    return [f"suggestion within {1e3 * found.within:g} mm; the outline moves by "
            f"{1e3 * found.outline:.2g} mm, the centre of mass by {1e3 * found.center_shift:.2g}:",
            *(f"  {line}" for line in steps),
            *([f"  gone: wanted {name_poses(found.lost)}"] if found.lost else []),
            f"by estimate: {100.0 * found.before:.1f} -> {100.0 * found.after:.1f} %; it chose "
            "these steps and so flatters them",
            f"by drops: {_bounded(found.dropped_before)} -> {_bounded(found.dropped_after)}; gain "
            f"{100.0 * gain.value:+.1f} points, 90 % interval {100.0 * gain.low:+.1f} to "
            f"{100.0 * gain.high:+.1f} ({found.drops} drops of both from the same starts, seed "
            f"{found.seed}, that had no say in the choice)",
            *([ended] if (ended := describe_time(found)) else []), JUDGED]


def _bounded(share: Bounded) -> str:
    return (f"{100.0 * share.value:.1f} % [{100.0 * share.low:.1f} to "
            f"{100.0 * share.high:.1f} %]")
