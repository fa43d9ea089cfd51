"""The row of a part: what its file holds, how it comes to rest, and what a feeder gets."""

import math
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...base import errors, text
from ...core.estimators import estimate_in
from ...core.mesh import files, mass_properties, parts
from ...core.planning import auto, confidence
from ...core.records import Array, Part, PoseStatistics
from ...core.records.plain_values import plain_value
from ...core.records.poses import PoseGroup
from ...core.resting.poses import poses_in
from ...core.statistics import feeding, pose_groups
from ..plots.poses import pose_thumbnail
from .request import CatalogueRequest

Row = dict[str, Any]

TARGET_OUTSIDE = 0.02
"""Error to which parts are dropped that the estimate was not measured on, without another target:
by such an estimate none is ranked."""


class Described(NamedTuple):
    """What came of a part."""

    # by the columns of `store.COLUMNS` as far as they are known; `poses` is a list of rows by
    # `store.POSE_COLUMNS`. Plain values, for JSON: what is not known is None
    row: Row
    picture: bytes | None  # PNG file of the most probable pose
    to_be_dropped: bool  # whether the estimate is not as sure as the target error asks
    seconds: float  # that it took


def describe_part(
    name: str,
    content: bytes | errors.PoseStatsError | None,
    request: CatalogueRequest,
    drop: bool,
    threads: int = 1,
) -> Described:
    """Look at one part. The answer depends on file and request alone, wherever it is made.

    `content`: what the file holds, or why it cannot be read; None where it is to be read here;
    `drop`: whether to keep the target error, if need be by drops.
    """
    begin = time.perf_counter()
    try:
        row, picture, open_ = _described(name, content, request, drop, threads)
    except errors.PoseStatsError as refusal:
        row = refused(name, str(refusal))
        picture = None
        open_ = False
    except Exception as error:  # one part must not cost all others their rows
        row = refused(
            name,
            f"failed inside the program ({type(error).__name__}: {error}); please report "
            "it with the file",
        )
        picture = None
        open_ = False
    return Described(row, picture, open_, time.perf_counter() - begin)


def refused(name: str, why: str) -> Row:
    """The row of a part that has no other answer."""
    return {"file": name, "refusal": " ".join(why.split())}


def content_of(name: str) -> bytes | errors.PoseStatsError:
    """What a file holds, or why it cannot be read."""
    try:
        return files.read_bytes(Path(name))
    except errors.PoseStatsError as refusal:
        return refusal


def _described(
    name: str,
    content: bytes | errors.PoseStatsError | None,
    request: CatalogueRequest,
    drop: bool,
    threads: int,
) -> tuple[Row, bytes, bool]:
    path = Path(name)
    scene = request.scene
    held = content_of(name) if content is None else content
    if isinstance(held, errors.PoseStatsError):
        raise held
    mesh = files.parse_mesh(path, held, request.unit, unless_declared=True)
    given = mass_properties.check_properties(None, None, None, request.density)
    part = parts.part_of_file(mesh, given, path.stem)
    found = estimate_in(part, scene)  # which may be sure enough
    outside = any(text.code_of(one) == "OUTSIDE_FIT" for one in found.warnings)
    target = request.target_error or (TARGET_OUTSIDE if outside else 0.0)
    if drop or not target:
        # From a seed of the part's own: equal parts have equal rows, in whatever order.
        found = auto.auto(
            part, target, None, seed=part.seed, workers=threads, **asdict(scene)
        )
    groups = pose_groups.pose_groups(found)
    row = {
        "file": name,
        "unit_declared": mesh.declared is not None,
        **_row(part, found, groups),
        "refusal": "",
        "poses": [_pose_row(group, pose) for group in groups for pose in group.poses],
    }
    return (
        plain_value(row),
        pose_thumbnail(part, groups[0].first, found.radius),
        bool(target)
        and not drop
        and confidence.estimate_bound(
            confidence.estimate_prior(found, poses_in(part, scene), scene)
        )
        > target,
    )


def _row(part: Part, found: PoseStatistics, groups: Sequence[PoseGroup]) -> Row:
    size = np.ptp(part.surface_vertices, axis=0).tolist()
    best = groups[0]
    length, width = footprint(best.first.outline)
    passes = feeding.passes_of(
        best.probability, best.probability_low, best.probability_high
    )
    return {
        "part_digest": part.digest,
        "triangles": len(part.triangles),
        "size_x_m": size[0],
        "size_y_m": size[1],
        "size_z_m": size[2],
        "stable_poses": len(found.poses),
        "distinct_poses": len(groups),
        "method": found.method,
        "drops": found.drops,
        "expected_error": found.expected_error,
        "largest_error": found.largest_error,
        "best_pose": best.first.index,
        "best_share": best.probability,
        "best_share_low": best.probability_low,
        "best_share_high": best.probability_high,
        "entropy_bits": entropy([group.probability for group in groups]),
        "passes": passes.value,
        "passes_low": passes.low,
        "passes_high": passes.high,
        "footprint_length_m": length,
        "footprint_width_m": width,
        "top_m": best.first.top,
        "warnings": list(found.warnings),
    }


def _pose_row(group: PoseGroup, pose: Any) -> Row:
    length, width = footprint(pose.outline)
    return {
        "pose": pose.index,
        "group": pose.group,
        "group_size": group.size,
        "group_share": group.probability,
        "group_share_low": group.probability_low,
        "group_share_high": group.probability_high,
        "probability": pose.probability,
        "probability_low": pose.probability_low,
        "probability_high": pose.probability_high,
        "standard_error": pose.standard_error,
        "count": pose.count,
        "footprint_length_m": length,
        "footprint_width_m": width,
        "top_m": pose.top,
        "height_m": pose.height,
        "margin_rad": pose.margin,
        "barrier_m": pose.barrier,
        "rolls": pose.rolls,
    }


def entropy(shares: Sequence[float]) -> float:
    """Entropy of shares that add up to 1, in bits: 0 where a part always lies the same way."""
    if any(map(math.isnan, shares)):
        return math.nan
    return -sum(share * math.log2(share) for share in shares if share > 0.0) + 0.0


def footprint(outline: Array) -> tuple[float, float]:
    """Length and width of the smallest rectangle around an outline (Freeman and Shapira, 1975)."""
    sides = np.roll(outline, -1, axis=0) - outline
    lengths = np.hypot(*sides.T)
    along = sides[lengths > 0.0] / lengths[lengths > 0.0, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    one = np.ptp(outline @ along.T, axis=0)
    other = np.ptp(outline @ across.T, axis=0)
    # About a triangle all three have one area but for rounding: then the narrowest.
    wide = np.minimum(one, other) / np.maximum(one, other)
    least = int(np.argmin(one * other * (1.0 + 1e-9 * wide)))
    return float(max(one[least], other[least])), float(min(one[least], other[least]))
