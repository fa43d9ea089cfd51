"""What a comparison found, in sentences; those of the command and of the page are the same."""

from __future__ import annotations

import math
from string import ascii_uppercase

from ..text import listed, several
from .comparison import ALIKE, Comparison, VariantComparison


def letter(variant: int) -> str:
    """Name of a variant by its place, from A on."""
    return ascii_uppercase[variant]


def describe_verdict(found: Comparison, one: VariantComparison) -> str:
    """Whether a variant differs from the first one, and by what that was judged."""
    both = f"A and {letter(one.second)}"
    if one.by_chance == ALIKE:
        widest = max(share.half_width for share in one.shares)
        return (f"{both}: no difference seen in {found.drops} drops of each; the widest interval "
                f"of a difference is {200.0 * widest:.1f} points.")
    if one.on_plate == ALIKE:
        return (f"{both} differ by more than chance in the model, but not by more than its error: "
                f"a real plate may not show it.")
    return f"{both} are different, by more than chance and the error of the model."


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
