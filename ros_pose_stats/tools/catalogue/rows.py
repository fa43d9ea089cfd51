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

"""The row of a part: its file, how it comes to rest, and what a feeder gets."""

import math
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...base import errors
from ...core.mesh import files, mass_properties, parts
from ...core.planning import auto
from ...core.records import Array, Part, PoseStatistics
from ...core.records.notes import has_note
from ...core.records.plain_values import plain_value
from ...core.records.poses import PoseGroup
from ...core.statistics import feeding, pose_groups
from ..plots.poses import pose_thumbnail
from .request import CatalogueRequest

Row = dict[str, Any]

FEW_DROPS = 1_000
"""The most by which a part is dropped beside others; those that a target asks more of
wait until all have a row, and then have all threads."""


class Described(NamedTuple):
    """What came of a part."""

    # by the columns of `store.COLUMNS` as far as they are known; `poses` is a list of
    # rows by `store.POSE_COLUMNS`. Plain values, for JSON: what is not known is None
    row: Row
    picture: bytes | None  # PNG file of the most probable pose
    to_be_dropped: bool  # whether the target error asks for more drops
    seconds: float  # that it took


def describe_part(
    name: str,
    content: bytes | errors.PoseStatsError | None,
    request: CatalogueRequest,
    drop: bool,
    threads: int = 1,
) -> Described:
    """Look at one part. The answer depends on file and request alone.

    `content`: what the file holds, or why it cannot be read; None where it is to be
    read here; `drop`: whether to keep the target error by as many drops as that takes.
    """
    begin = time.perf_counter()
    picture = None
    to_be_dropped = False
    try:
        row, picture, to_be_dropped = _described(name, content, request, drop, threads)
    except errors.PoseStatsError as refusal:
        row = refused(name, str(refusal))
    except Exception as error:  # one part must not cost all others their rows
        row = refused(
            name,
            f"failed inside the program ({type(error).__name__}: {error}); please "
            "report it with the file",
        )
    return Described(row, picture, to_be_dropped, time.perf_counter() - begin)


def refused(name: str, reason: str) -> Row:
    """The row of a part that has no other answer."""
    return {"file": name, "refusal": " ".join(reason.split())}


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
    if content is None:
        content = content_of(name)
    if isinstance(content, errors.PoseStatsError):
        raise content
    mesh = files.parse_mesh(path, content, request.unit, unless_declared=True)
    mass = mass_properties.check_properties(None, None, None, request.density)
    part = parts.part_of_file(mesh, mass, path.stem)
    target = request.target_error
    is_bounded = target > 0.0 and not drop
    statistics = auto.auto(
        part,
        target,
        FEW_DROPS if is_bounded else None,
        workers=threads,
        **asdict(scene),
    )
    to_be_dropped = is_bounded and has_note(statistics, "TARGET_MISSED")
    groups = pose_groups.pose_groups(statistics)
    row = {
        "file": name,
        "unit_declared": mesh.declared is not None,
        **_row(part, statistics, groups),
        "refusal": "",
        "poses": [_pose_row(group, pose) for group in groups for pose in group.poses],
    }
    picture = pose_thumbnail(part, groups[0].first, statistics.radius)
    return plain_value(row), picture, to_be_dropped


def _row(part: Part, estimate: PoseStatistics, groups: Sequence[PoseGroup]) -> Row:
    size = np.ptp(part.surface_vertices, axis=0).tolist()
    best = groups[0]
    length, width = footprint(best.first.outline)
    passes = feeding.passes_of(
        best.probability, best.probability_low, best.probability_high
    )
    return {
        "part_digest": part.digest,
        "unit_m": part.unit,
        "unit_guessed": part.unit_guessed,
        "triangles": len(part.triangles),
        "size_x_m": size[0],
        "size_y_m": size[1],
        "size_z_m": size[2],
        "stable_poses": len(estimate.poses),
        "distinct_poses": len(groups),
        "method": estimate.method,
        "drops": estimate.drops,
        "expected_error": estimate.expected_error,
        "largest_error": estimate.largest_error,
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
        "warnings": list(estimate.warnings),
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
    """Entropy of shares that add up to 1, in bits; 0 for a single pose."""
    if any(map(math.isnan, shares)):
        return math.nan
    return -sum(share * math.log2(share) for share in shares if share > 0.0) + 0.0


def footprint(outline: Array) -> tuple[float, float]:
    """Length and width of the smallest rectangle (Freeman and Shapira, 1975)."""
    sides = np.roll(outline, -1, axis=0) - outline
    lengths = np.hypot(*sides.T)
    direction = sides[lengths > 0.0] / lengths[lengths > 0.0, None]
    perpendicular = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    extent = np.ptp(outline @ direction.T, axis=0)
    width = np.ptp(outline @ perpendicular.T, axis=0)
    # About a triangle all three have one area but for rounding: then the narrowest.
    slenderness = np.minimum(extent, width) / np.maximum(extent, width)
    smallest = np.argmin(extent * width * (1.0 + 1e-9 * slenderness))
    shorter, longer = sorted((extent[smallest], width[smallest]))
    return longer, shorter
