"""Features and their changes in words, and results as plain values for JSON."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..statistics.paired_counts import PairedDifference
from ..text import listed
from .changes import DesignSpace
from .effects import Effect, Sensitivity
from .features import AXES
from .suggest import Suggestion

JUDGED = ("judged by the outer shape (the convex hull) and the centre of mass alone, not by "
          "whether the part can be made or still does its work")


def describe_order(found: Sensitivity) -> str:
    """In which order effects stand: a millimetre and a percent have no common measure."""
    return (f"in the order of what a step changes, {1e3 * found.step:.3g} mm or "
            f"{100.0 * found.step / found.space.body.radius:.3g} % of stretching, the most first")


def describe_time(found: Sensitivity | Suggestion) -> str:
    """That time ended the drops, and how to go on; nothing where it did not."""
    if not found.out_of_time:
        return ""
    return (f"time ended the drops after {found.drops} of {found.most_drops}; --drops "
            f"{found.most_drops} does them all")


CONTRADICTED = "drops contradict the estimate"


def place(space: DesignSpace, number: int) -> list[float]:
    """Middle (3,) of a feature in the part frame, metres; of axes the centre of mass."""
    anchor = space.features[number].anchor * space.body.radius
    return [float(x) + 0.0 for x in space.part.center_of_mass + anchor]


def name_feature(space: DesignSpace, number: int) -> str:
    """What is changed, in words."""
    feature = space.features[number]
    if feature.kind == "centre":
        return f"centre of mass along {AXES[feature.axis]}"
    if feature.kind == "stretch":
        return f"stretched along {AXES[feature.axis]}"
    if feature.kind == "face":
        return f"face of pose {listed(feature.poses)} outward"
    where = ", ".join(f"{1e3 * x:.3g}" for x in np.round(place(space, number), 7))
    return f"{'rounded edge' if feature.is_rounded else 'edge'} at ({where}) mm cut"


def name_step(space: DesignSpace, number: int, step: float) -> str:
    """What a step does, in words."""
    feature, length = space.features[number], f"{1e3 * abs(step):.3g} mm"
    if feature.kind == "centre":
        return f"centre of mass {length} towards {'-' if step < 0.0 else '+'}{AXES[feature.axis]}"
    if feature.kind == "stretch":
        longer = abs(step) * float(np.ptp(space.part.surface_vertices[:, feature.axis]))
        return f"{'shrunk' if step < 0.0 else 'stretched'} by {100.0 * abs(step):.3g} % along " \
               f"{AXES[feature.axis]} ({1e3 * longer:.3g} mm)"
    if feature.kind == "face":
        return f"face of pose {listed(feature.poses)} moved {'in' if step < 0.0 else 'out'} by " \
               f"{length}"
    return f"{name_feature(space, number)} by {length}" + (
        " more than its rounding" if feature.is_rounded else "")


def suggested_steps(found: Suggestion) -> list[str]:
    """The steps of a suggestion in words; those that symmetry ties together are one line."""
    lines = []
    for tied in found.taken:
        line = name_step(found.space, tied[0], float(found.steps[tied[0]]))
        others = [name_step(found.space, one, float(found.steps[one])) for one in tied[1:]
                  if found.space.features[one].kind in ("centre", "stretch")]
        alike = len(tied) - 1 - len(others)
        lines.append(listed([line, *others]) + (f", and {alike} more like it" if alike else ""))
    return lines


def sensitivity_as_dict(found: Sensitivity) -> dict[str, Any]:
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


def suggestion_as_dict(found: Suggestion) -> dict[str, Any]:
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


def _feature(space: DesignSpace, number: int) -> dict[str, Any]:
    feature = space.features[number]
    return {"kind": feature.kind, "axis": AXES[feature.axis] if feature.axis >= 0 else None,
            "poses": list(feature.poses), "place": place(space, number),
            "size": feature.size * space.body.radius ** (2 if feature.kind == "face" else 1),
            "unit": "m" if feature.is_length else "1"}


def _effect(space: DesignSpace, effect: Effect) -> dict[str, Any]:
    return {**_feature(space, effect.number), "alike": len(effect.alike), "slope": effect.slope,
            "error": effect.error, "step": effect.step, "change": effect.change,
            "lost": list(effect.lost), "contradicted": effect.contradicted,
            "check": None if effect.check is None else _difference(effect.check)}


def _difference(found: PairedDifference) -> dict[str, Any]:
    known = {"change": found.value, "standard_error": found.standard_error, "low": found.low,
             "high": found.high, "drops": found.trials, "p_value": found.p_value}
    return {name: value if math.isfinite(value) else None for name, value in known.items()}
