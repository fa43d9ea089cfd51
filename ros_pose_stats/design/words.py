"""What a comparison found, in sentences; those of the command and of the page are the same."""

from __future__ import annotations

import math
from string import ascii_uppercase

from ..statistics.feeding import Bounded
from ..text import listed, name_poses, several
from .comparison import NONE_SHOWN, SHOWN, Comparison, ShareDifference, VariantComparison


def letter(variant: int) -> str:
    """Name of a variant by its place, from A on."""
    return ascii_uppercase[variant]


def describe_verdict(found: Comparison, one: VariantComparison) -> str:
    """Whether a variant differs from the first one: in what is accepted, else in any pose."""
    other, drops = letter(one.second), f"{found.drops} drops of each"
    if one.feeder is not None:
        share = one.feeder.share
        return (f"Accepted are {_percent(share.first)} of A and {_percent(share.second)} of "
                f"{other}, {other} - A {_points(share)}: {name_verdict(share)} in {drops}."
                f"{_largest(one, 'Of single poses the largest difference')}")
    verdict = name_verdict(one)
    if one.in_model == NONE_SHOWN:
        widest = max(share.half_width for share in one.shares)
        return (f"A and {other}: {verdict} in {drops}; the widest interval of a difference is "
                f"{200.0 * widest:.1f} points.")
    return f"A and {other}: {verdict}.{_largest(one, 'The largest')}"


def name_verdict(judged: ShareDifference | VariantComparison) -> str:
    """Both verdicts in one phrase."""
    if judged.on_plate == SHOWN:
        return "difference shown, in the model and on a plate"
    if judged.in_model == SHOWN:
        return "difference shown in the model, none on a plate"
    return "no difference shown"


def _largest(one: VariantComparison, what: str) -> str:
    """The largest difference of a pose that is shown, on a plate if any is; nothing for none."""
    shown = ([pose for pose in one.poses if pose.share.on_plate == SHOWN]
             or [pose for pose in one.poses if pose.share.in_model == SHOWN])
    if not shown:
        return ""
    largest = max(shown, key=lambda pose: abs(pose.share.difference.value))
    where = "on a plate" if largest.share.on_plate == SHOWN else "in the model"
    sides = [f"{name_poses(poses)} of {name}" for name, poses in
             zip(("A", letter(one.second)), largest.poses, strict=True) if poses]
    alone = "" if largest.poses.is_pair else ", without a partner"
    return (f" {what} shown {where} is {_points(largest.share)}, of {listed(sides)}{alone}.")


def _percent(share: Bounded) -> str:
    return f"{100.0 * share.value:.1f} %"


def _points(share: ShareDifference) -> str:
    """A signed difference with its interval."""
    value, low, high = (f"{round(100.0 * one, 1) + 0.0:+.1f}" for one in (
        share.difference.value, share.difference.low, share.difference.high))
    return f"{value} points ({low} to {high})"


def describe_matching(one: VariantComparison) -> list[str]:
    """What is to be known about which poses correspond; nothing where all do, in one frame."""
    match, other = one.correspondence, letter(one.second)
    told = []
    if match.turn is not None:
        what = "is the same body as A" if match.same_body else "is A with changes"
        told.append(f"{other} {what}, turned by {math.degrees(match.angle):.0f} degrees in the "
                    f"frame of its file; poses are compared as if it were not.")
    if not match.by_orientation and any(pose.poses.is_pair for pose in one.poses):
        told.append(f"The frames of A and {other} do not match: poses are matched by footprint "
                    f"and height alone, and which side of the part is up is not compared.")
    alone = [sum(len(pose.poses[side]) for pose in one.poses if not pose.poses.is_pair)
             for side in (0, 1)]
    if any(alone):
        told.append(f"Without a partner: {several(alone[0], 'pose')} of A and "
                    f"{several(alone[1], 'pose')} of {other}.")
    return told


def name_warnings(found: Comparison) -> dict[str, str]:
    """Warnings of all variants, each once, with the variants that it is said of."""
    whose: dict[str, list[str]] = {}
    for place, one in enumerate(found.found):
        for warning in dict.fromkeys(one.warnings):
            whose.setdefault(warning, []).append(letter(place))
    return {warning: listed(letters) for warning, letters in whose.items()}
