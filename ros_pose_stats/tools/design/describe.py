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

"""Features, changes and verdicts in words."""

import math
from typing import Any

import numpy as np

from ...base.text import listed, name_poses, points, several
from ...core.records import Array
from ...core.records.notes import Note
from ...core.records.plain_values import without_rounding
from . import changes, comparison, paired_drops

JUDGED = (
    "judged by the outer shape (the convex hull) and the centre of mass alone, not by "
    "whether the part can be made or still does its work"
)

CONTRADICTED = "drops contradict the estimate"
UNSURE = "not sure"
SURE = (
    "a gain is sure where chance alone shows one in at most one answer of two hundred"
)


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
        longer = abs(step) * np.ptp(space.part.surface_vertices[:, feature.axis])
        return (
            f"{'shrunk' if step < 0.0 else 'stretched'} by {100.0 * abs(step):.3g} % "
            f"along {changes.AXES[feature.axis]} ({1e3 * longer:.3g} mm)"
        )
    direction = "in" if step < 0.0 else "out"
    return f"face of pose {listed(feature.poses)} moved {direction} by {length}"


def name_moves(space: changes.DesignSpace, moves: Array) -> str:
    """Steps of features (n,) in words.

    Faces that symmetry ties together count with the first.
    """
    features = np.flatnonzero(moves).tolist()
    named_features = [
        number
        for number in features
        if number == features[0] or space.features[number].kind != "face"
    ]
    unnamed = len(features) - len(named_features)
    return listed(
        [name_step(space, number, moves[number]) for number in named_features]
    ) + (f", and {unnamed} more like it" if unnamed else "")


def feature_as_dict(space: changes.DesignSpace, number: int) -> dict[str, Any]:
    """Plain values; its place, in the part frame, is the centre of mass for axes."""
    feature = space.features[number]
    radius = space.body.radius
    position = space.part.center_of_mass + feature.anchor * radius
    return {
        "kind": feature.kind,
        "axis": changes.AXES[feature.axis] if feature.axis >= 0 else None,
        "poses": feature.poses,
        "place": without_rounding(position, radius),
        "size": feature.size * radius**2,
        "unit": "m" if feature.is_length else "1",
    }


def difference_as_dict(difference: paired_drops.PairedDifference) -> dict[str, Any]:
    """What JSON says of a difference."""
    return {
        "change": difference.value,
        "standard_error": difference.standard_error,
        "low": difference.low,
        "high": difference.high,
        "drops": difference.trials,
        "p_value": difference.p_value,
    }


letter = "ABCDEFGHIJKLMNOPQRSTUVWXYZ".__getitem__
"""Name of a variant by its place, from A on."""

ON_PLATE = {
    comparison.DIFFERENCE_SHOWN: "large enough to expect on a real plate",
    comparison.NO_DIFFERENCE: "shown in the model, too small to expect on a real plate",
}


def describe_verdict(
    result: comparison.Comparison, variant: comparison.VariantComparison
) -> str:
    """Which variant feeds better, and by how much; without a feeder, what differs."""
    variant_letter = letter(variant.second)
    share = variant.deciding
    if not result.drops:
        return f"A and {variant_letter}: not dropped yet"
    if share.in_model == comparison.NO_DIFFERENCE:
        if variant.feeder is not None:
            return (
                f"{result.drops} drops of each show no difference in feeding: "
                f"{_percent(share.second.value)} of {variant_letter} accepted, "
                f"{_percent(share.first.value)} of A ({_points(share, 1.0)})"
            )
        bound = max(
            max(-share.difference.low, share.difference.high)
            for share in variant.shares
        )
        return (
            f"{result.drops} drops of each show no difference of A and "
            f"{variant_letter}: no share differs by more than "
            f"{100.0 * bound:.1f} points"
        )
    if variant.feeder is None:
        poses = next(pose.poses for pose in variant.poses if pose.share is share)
        sides = [
            f"{name} {_percent(side.value)} in {name_poses(indices)}"
            if indices
            else f"{name} has no such pose"
            for name, side, indices in zip(
                (variant_letter, "A"),
                (share.second, share.first),
                poses[::-1],
                strict=True,
            )
        ]
        return (
            f"{variant_letter} differs from A, most here: {', '.join(sides)} "
            f"({_points(share, 1.0)}); {ON_PLATE[share.on_plate]}"
        )
    values = (share.second.value, share.first.value)
    better, sign = (
        (variant_letter, 1.0) if share.difference.value >= 0.0 else ("A", -1.0)
    )
    worse = "A" if sign > 0.0 else variant_letter
    return (
        f"{better} feeds better: {_percent(max(values))} accepted, {worse} "
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


def describe_matching(variant: comparison.VariantComparison) -> list[str]:
    """Remarks about which poses correspond; none where all do, in one frame."""
    match = variant.correspondence
    name = letter(variant.second)
    lines = []
    if match.turn is not None:
        change = "is the same body as A" if match.same_body else "is A with changes"
        lines.append(
            f"{name} {change}, turned by {math.degrees(match.angle):.0f} degrees in "
            f"the frame of its file; poses are compared as if it were not."
        )
    if not match.by_orientation and any(pose.poses.is_pair for pose in variant.poses):
        lines.append(
            f"The frames of A and {name} do not match: poses are matched by footprint "
            f"and height alone, and which side of the part is up is not compared."
        )
    partnerless = [
        sum(len(pose.poses[side]) for pose in variant.poses if not pose.poses.is_pair)
        for side in (0, 1)
    ]
    if any(partnerless):
        lines.append(
            f"Without a partner: {several(partnerless[0], 'pose')} of A and "
            f"{several(partnerless[1], 'pose')} of {name}."
        )
    return lines


def name_warnings(result: comparison.Comparison) -> list[tuple[str, Note]]:
    """Warnings of all variants, each once, behind their variants."""
    letters_of: dict[Note, list[str]] = {}
    for number, statistics in enumerate(result.statistics):
        for warning in dict.fromkeys(statistics.warnings):
            letters_of.setdefault(warning, []).append(letter(number))
    return [(listed(letters), warning) for warning, letters in letters_of.items()]
