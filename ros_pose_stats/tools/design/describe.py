"""Features, changes and verdicts in words."""

import math
from typing import Any

import numpy as np

from ...base.text import listed, name_poses, points, several
from ...core.records import Array
from ...core.records.plain_values import without_rounding
from . import changes, comparison, paired_drops

JUDGED = (
    "judged by the outer shape (the convex hull) and the centre of mass alone, not by "
    "whether the part can be made or still does its work"
)

CONTRADICTED = "drops contradict the estimate"


def name_step(space: changes.DesignSpace, number: int, step: float) -> str:
    """What a step does, in words."""
    feature = space.features[number]
    length = f"{1e3 * abs(step):.3g} mm"
    if feature.kind == "centre":
        return (
            f"centre of mass {length} towards "
            f"{'-' if step < 0.0 else '+'}{changes.AXES[feature.axis]}"
        )
    if feature.kind == "stretch":
        longer = abs(step) * float(np.ptp(space.part.surface_vertices[:, feature.axis]))
        return (
            f"{'shrunk' if step < 0.0 else 'stretched'} by {100.0 * abs(step):.3g} % along "
            f"{changes.AXES[feature.axis]} ({1e3 * longer:.3g} mm)"
        )
    way = "in" if step < 0.0 else "out"
    return f"face of pose {listed(feature.poses)} moved {way} by {length}"


def name_moves(space: changes.DesignSpace, moves: Array) -> str:
    """Steps of features (n,) in words; faces that symmetry ties together count with the first."""
    moved = np.flatnonzero(moves).tolist()
    named = [
        one for one in moved if one == moved[0] or space.features[one].kind != "face"
    ]
    more = len(moved) - len(named)
    return listed([name_step(space, one, float(moves[one])) for one in named]) + (
        f", and {more} more like it" if more else ""
    )


def feature_as_dict(space: changes.DesignSpace, number: int) -> dict[str, Any]:
    """Plain values; its place is in the part frame, metres, of axes the centre of mass."""
    feature = space.features[number]
    radius = space.body.radius
    place = space.part.center_of_mass + feature.anchor * radius
    return {
        "kind": feature.kind,
        "axis": changes.AXES[feature.axis] if feature.axis >= 0 else None,
        "poses": feature.poses,
        "place": without_rounding(place, radius),
        "size": feature.size * radius**2,
        "unit": "m" if feature.is_length else "1",
    }


def difference_as_dict(found: paired_drops.PairedDifference) -> dict[str, Any]:
    """What JSON says of a difference."""
    return {
        "change": found.value,
        "standard_error": found.standard_error,
        "low": found.low,
        "high": found.high,
        "drops": found.trials,
        "p_value": found.p_value,
    }


letter = "ABCDEFGHIJKLMNOPQRSTUVWXYZ".__getitem__
"""Name of a variant by its place, from A on."""

ON_PLATE = {
    comparison.SHOWN: "large enough to expect on a real plate",
    comparison.NONE_SHOWN: "shown in the model, too small to expect on a real plate",
}


def describe_verdict(
    found: comparison.Comparison, one: comparison.VariantComparison
) -> str:
    """Which variant feeds better, and by how much; where no feeder is asked for, what differs."""
    other = letter(one.second)
    share = one.deciding
    if not found.drops:
        return f"A and {other}: not dropped yet"
    if share.in_model == comparison.NONE_SHOWN:
        if one.feeder is not None:
            return (
                f"{found.drops} drops of each show no difference in feeding: "
                f"{_percent(share.second.value)} of {other} accepted, "
                f"{_percent(share.first.value)} of A ({_points(share, 1.0)})"
            )
        bound = max(
            max(-share.difference.low, share.difference.high) for share in one.shares
        )
        return (
            f"{found.drops} drops of each show no difference of A and {other}: no share "
            f"differs by more than {100.0 * bound:.1f} points"
        )
    if one.feeder is None:
        poses = next(pose.poses for pose in one.poses if pose.share is share)
        sides = [
            f"{name} {_percent(side.value)} in {name_poses(some)}"
            if some
            else f"{name} has no such pose"
            for name, side, some in zip(
                (other, "A"), (share.second, share.first), poses[::-1], strict=True
            )
        ]
        return (
            f"{other} differs from A, most here: {', '.join(sides)} "
            f"({_points(share, 1.0)}); {ON_PLATE[share.on_plate]}"
        )
    values = (share.second.value, share.first.value)
    better, sign = (other, 1.0) if share.difference.value >= 0.0 else ("A", -1.0)
    rest = "A" if sign > 0.0 else other
    return (
        f"{better} feeds better: {_percent(max(values))} accepted, {rest} "
        f"{_percent(min(values))} ({_points(share, sign)}); {ON_PLATE[share.on_plate]}"
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def _points(share: comparison.ShareDifference, sign: float) -> str:
    """A signed difference, and its interval."""
    ends = sorted((sign * share.difference.low, sign * share.difference.high))
    return (
        f"{points(sign * share.difference.value)} points, "
        f"{' to '.join(f'{round(100.0 * end, 1) + 0.0:.1f}' for end in ends)}"
    )


def describe_matching(one: comparison.VariantComparison) -> list[str]:
    """What is to be known about which poses correspond; nothing where all do, in one frame."""
    match = one.correspondence
    other = letter(one.second)
    lines = []
    if match.turn is not None:
        what = "is the same body as A" if match.same_body else "is A with changes"
        lines.append(
            f"{other} {what}, turned by {math.degrees(match.angle):.0f} degrees in the "
            f"frame of its file; poses are compared as if it were not."
        )
    if not match.by_orientation and any(pose.poses.is_pair for pose in one.poses):
        lines.append(
            f"The frames of A and {other} do not match: poses are matched by footprint "
            f"and height alone, and which side of the part is up is not compared."
        )
    alone = [
        sum(len(pose.poses[side]) for pose in one.poses if not pose.poses.is_pair)
        for side in (0, 1)
    ]
    if any(alone):
        lines.append(
            f"Without a partner: {several(alone[0], 'pose')} of A and "
            f"{several(alone[1], 'pose')} of {other}."
        )
    return lines


def name_remarks(found: comparison.Comparison, kind: str) -> list[tuple[str, str]]:
    """`warnings` or `notes` of all variants, each once, behind the variants that it is said of."""
    whose: dict[str, list[str]] = {}
    for place, one in enumerate(found.found):
        for line in dict.fromkeys(getattr(one, kind)):
            whose.setdefault(line, []).append(letter(place))
    return [(listed(letters), line) for line, letters in whose.items()]
