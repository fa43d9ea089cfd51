"""Comparisons, features and changes in words, and results as plain values for JSON."""

import math
from string import ascii_uppercase
from typing import Any

import numpy as np

from ..statistics import feeding, paired_counts
from ..text import listed, name_poses, several
from . import changes, comparison, effects, features, suggest


def letter(variant: int) -> str:
    """Name of a variant by its place, from A on."""
    return ascii_uppercase[variant]


def describe_verdict(found: comparison.Comparison, one: comparison.VariantComparison) -> str:
    """Whether a variant differs from the first one: in what is accepted, else in any pose."""
    other, drops = letter(one.second), f"{found.drops} drops of each"
    if one.feeder is not None:
        share = one.feeder.share
        return (f"Accepted are {_percent(share.first)} of A and {_percent(share.second)} of "
                f"{other}, {other} - A {_points(share)}: {name_verdict(share)} in {drops}."
                f"{_largest(one, 'Of single poses the largest difference')}")
    verdict = name_verdict(one)
    if one.in_model == comparison.NONE_SHOWN:
        widest = max(share.half_width for share in one.shares)
        return (f"A and {other}: {verdict} in {drops}; the widest interval of a difference is "
                f"{200.0 * widest:.1f} points.")
    return f"A and {other}: {verdict}.{_largest(one, 'The largest')}"


def name_verdict(judged: comparison.ShareDifference | comparison.VariantComparison) -> str:
    """Both verdicts in one phrase."""
    if judged.on_plate == comparison.SHOWN:
        return "difference shown, in the model and on a plate"
    if judged.in_model == comparison.SHOWN:
        return "difference shown in the model, none on a plate"
    return "no difference shown"


def _largest(one: comparison.VariantComparison, what: str) -> str:
    """The largest difference of a pose that is shown, on a plate if any is; nothing for none."""
    shown = ([pose for pose in one.poses if pose.share.on_plate == comparison.SHOWN]
             or [pose for pose in one.poses if pose.share.in_model == comparison.SHOWN])
    if not shown:
        return ""
    largest = max(shown, key=lambda pose: abs(pose.share.difference.value))
    where = "on a plate" if largest.share.on_plate == comparison.SHOWN else "in the model"
    sides = [f"{name_poses(poses)} of {name}" for name, poses in
             zip(("A", letter(one.second)), largest.poses, strict=True) if poses]
    alone = "" if largest.poses.is_pair else ", without a partner"
    return (f" {what} shown {where} is {_points(largest.share)}, of {listed(sides)}{alone}.")


def _percent(share: feeding.Bounded) -> str:
    return f"{100.0 * share.value:.1f} %"


def _points(share: comparison.ShareDifference) -> str:
    """A signed difference with its interval."""
    value, low, high = (f"{round(100.0 * one, 1) + 0.0:+.1f}" for one in (
        share.difference.value, share.difference.low, share.difference.high))
    return f"{value} points ({low} to {high})"


def describe_matching(one: comparison.VariantComparison) -> list[str]:
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


def name_remarks(found: comparison.Comparison, kind: str
                 ) -> list[tuple[str, str]]:
    """`warnings` or `notes` of all variants, each once, behind the variants that it is said of."""
    whose: dict[str, list[str]] = {}
    for place, one in enumerate(found.found):
        for line in dict.fromkeys(getattr(one, kind)):
            whose.setdefault(line, []).append(letter(place))
    return [(listed(letters), line) for line, letters in whose.items()]


JUDGED = ("judged by the outer shape (the convex hull) and the centre of mass alone, not by "
          "whether the part can be made or still does its work")


def describe_order(found: effects.Sensitivity) -> str:
    """In which order effects stand: a millimetre and a percent have no common measure."""
    return (f"in the order of what a step changes, {1e3 * found.step:.3g} mm or "
            f"{100.0 * found.step / found.space.body.radius:.3g} % of stretching, the most first")


def describe_time(found: effects.Sensitivity | suggest.Suggestion) -> str:
    """That time ended the drops, and how to go on; nothing where it did not."""
    if not found.out_of_time:
        return ""
    return (f"time ended the drops after {found.drops} of {found.most_drops}; --drops "
            f"{found.most_drops} does them all")


CONTRADICTED = "drops contradict the estimate"


def place(space: changes.DesignSpace, number: int) -> list[float]:
    """Middle (3,) of a feature in the part frame, metres; of axes the centre of mass."""
    anchor = space.features[number].anchor * space.body.radius
    return [float(x) + 0.0 for x in space.part.center_of_mass + anchor]


def name_feature(space: changes.DesignSpace, number: int) -> str:
    """What is changed, in words."""
    feature = space.features[number]
    if feature.kind == "centre":
        return f"centre of mass along {features.AXES[feature.axis]}"
    if feature.kind == "stretch":
        return f"stretched along {features.AXES[feature.axis]}"
    return f"face of pose {listed(feature.poses)} outward"


def name_step(space: changes.DesignSpace, number: int, step: float) -> str:
    """What a step does, in words."""
    feature, length = space.features[number], f"{1e3 * abs(step):.3g} mm"
    if feature.kind == "centre":
        return (f"centre of mass {length} towards "
                f"{'-' if step < 0.0 else '+'}{features.AXES[feature.axis]}")
    if feature.kind == "stretch":
        longer = abs(step) * float(np.ptp(space.part.surface_vertices[:, feature.axis]))
        return f"{'shrunk' if step < 0.0 else 'stretched'} by {100.0 * abs(step):.3g} % along " \
               f"{features.AXES[feature.axis]} ({1e3 * longer:.3g} mm)"
    way = "in" if step < 0.0 else "out"
    return f"face of pose {listed(feature.poses)} moved {way} by {length}"


def suggested_steps(found: suggest.Suggestion) -> list[str]:
    """The steps of a suggestion in words; those that symmetry ties together are one line."""
    lines = []
    for tied in found.taken:
        line = name_step(found.space, tied[0], float(found.steps[tied[0]]))
        others = [name_step(found.space, one, float(found.steps[one])) for one in tied[1:]
                  if found.space.features[one].kind in ("centre", "stretch")]
        alike = len(tied) - 1 - len(others)
        lines.append(listed([line, *others]) + (f", and {alike} more like it" if alike else ""))
    return lines


def sensitivity_as_dict(found: effects.Sensitivity) -> dict[str, Any]:
    """Plain values; lengths in metres, shares as fractions, NaN as None."""
    space = found.space
    return {"part_id": space.part.part_id, "part_digest": space.part.digest,
            "radius": space.body.radius, "method": found.method,
            "restitution": found.scene.restitution, "drop_height": found.scene.drop_height,
            "cluster_tolerance": found.scene.cluster_tolerance,
            "round_sides": found.scene.round_sides, "wanted": list(found.wanted),
            "share": found.share, "share_low": found.accepted.low,
            "share_high": found.accepted.high, "step": found.step,
            "effects": [_effect(space, one) for one in found.effects],
            "drops": found.drops, "most_drops": found.most_drops,
            "out_of_time": found.out_of_time, "seed": found.seed, "seconds": found.seconds,
            "warnings": list(found.warnings), "version": found.version}


def suggestion_as_dict(found: suggest.Suggestion) -> dict[str, Any]:
    """Plain values; lengths in metres, shares as fractions."""
    return {"within": found.within, "outline": found.outline, "center_shift": found.center_shift,
            "judged": JUDGED,
            "steps": [{**_feature(found.space, number), "step": float(found.steps[number])}
                      for number in np.flatnonzero(found.steps).tolist()],
            "estimate": {"before": found.before, "after": found.after,
                         "gain": found.after - found.before, "error": found.gain_error},
            "lost": list(found.lost),
            "by_drops": {"before": found.dropped_before._asdict(),
                         "after": found.dropped_after._asdict(), "gain": _difference(found.gain)},
            "center_of_mass": found.changed.part.center_of_mass.tolist(),
            "drops": found.drops, "most_drops": found.most_drops,
            "out_of_time": found.out_of_time, "seed": found.seed, "seconds": found.seconds}


def _feature(space: changes.DesignSpace, number: int) -> dict[str, Any]:
    feature = space.features[number]
    return {"kind": feature.kind, "axis": features.AXES[feature.axis] if feature.axis >= 0
            else None,
            "poses": list(feature.poses), "place": place(space, number),
            "size": feature.size * space.body.radius ** 2,
            "unit": "m" if feature.is_length else "1"}


def _effect(space: changes.DesignSpace, effect: effects.Effect) -> dict[str, Any]:
    return {**_feature(space, effect.number), "alike": len(effect.alike), "slope": effect.slope,
            "error": effect.error, "step": effect.step, "change": effect.change,
            "lost": list(effect.lost), "contradicted": effect.contradicted,
            "check": None if effect.check is None else _difference(effect.check)}


def _difference(found: paired_counts.PairedDifference) -> dict[str, Any]:
    known = {"change": found.value, "standard_error": found.standard_error, "low": found.low,
             "high": found.high, "drops": found.trials, "p_value": found.p_value}
    return {name: value if math.isfinite(value) else None for name, value in known.items()}
