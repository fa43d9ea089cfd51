"""Stable poses and their probabilities, as every method answers."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from html import escape
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from ...base import errors, version
from ...base.text import several
from .. import tolerances
from .part import Array, Index, Part
from .plain_values import with_units
from .pose_table import pose_table, probability_columns
from .poses import PoseGroup, StablePose, single_poses
from .scene import (
    DEFAULT_PLATE_ERROR,
    HIGHEST_DROP,
    SCENE_FIELDS,
    DropScene,
    describe_scene,
    height_warnings,
)

FORGOTTEN = "FORGOTTEN: "
"""Begins the warning of statistics without poses: their part is not known any more."""

STATISTICS_FIELDS = (
    "part_id",
    "part_digest",
    "radius",
    "method",
    *SCENE_FIELDS,
    "drops",
    "unsettled",
    "seed",
    "observed",
    "expected_error",
    "largest_error",
    "plate_error",
    "version",
)
"""Single values of statistics, as in JSON and in messages."""


@dataclass(frozen=True, eq=False)
class PoseStatistics:
    """The stable poses of a part, most probable first, and where that comes from.

    Attributes
    ----------
    part_id, part_digest : str
    radius : float
        Largest distance from the centre of mass to a vertex, metres.
    method : str
        Name of the estimator, `simulation`, `hybrid`, or `observed`.
    restitution : float
        Of the requested scene.
    drop_height : float
        Metres; NaN where the method ignores it.
    cluster_tolerance : float
        Least rise out of a pose as a share of its height there.
    poses : tuple of StablePose
        All of them, also those with probability 0.
    drops, unsettled, seed : int
    expected_error : float
        Root mean square over the poses against the model's own limit; NaN until
        measured.
    largest_error : float
        Bound that the error of every single pose keeps with 90 % confidence; NaN until
        measured.
    plate_error : float
        Expected root mean square, over groups of poses, against a real plate; no number
        of drops lowers it.
    seconds : float
        From mass properties to statistics, without reading files and imports.
    warnings : tuple of str
        What a person should act on, each `CODE: sentence`.
    notes : tuple of str
        What is peculiar about the part and asks for nothing, each `CODE: sentence`.
    version : str
        Of this package.
    round_sides : int
        Sides a turn of the polygons that round surfaces are taken as; 0: as in the
        file.
    observed : int
        Parts counted by cameras that the probabilities have learnt from; `count` of the
        poses are theirs then.
    choice : str
        Why this method was chosen, in one sentence; empty where the caller chose it.
    """

    part_id: str
    part_digest: str
    radius: float
    method: str
    restitution: float
    drop_height: float
    cluster_tolerance: float
    poses: tuple[StablePose, ...]
    drops: int = 0
    unsettled: int = 0
    seed: int = 0
    expected_error: float = math.nan
    largest_error: float = math.nan
    plate_error: float = DEFAULT_PLATE_ERROR
    seconds: float = math.nan
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    version: str = ""
    choice: str = ""
    round_sides: int = 0
    observed: int = 0

    @property
    def scene(self) -> str:
        """How high the part was released, onto what, and how bouncy, as a sentence."""
        return describe_scene(self.restitution, self.drop_height)

    def as_dict(self) -> dict[str, Any]:
        """The statistics as plain values under the keys of the JSON contract."""
        fields = (*STATISTICS_FIELDS, "seconds", "choice", "scene", "warnings", "notes")
        return with_units(
            {
                **{name: getattr(self, name) for name in fields},
                "units": {},  # before the poses, which are long
                "poses": [pose.as_dict() for pose in self.poses],
            }
        )

    @property
    def by_index(self) -> dict[int, StablePose]:
        """The poses by their `index`."""
        return {
            pose.index: pose for pose in sorted(self.poses, key=lambda pose: pose.index)
        }

    def to_frame(self) -> Any:
        """The poses as a pandas DataFrame with the keys of JSON as columns, by `index`.

        Raises
        ------
        RequestError
            If pandas is not installed.
        """
        try:
            pandas = import_module("pandas")
        except ImportError as error:
            raise errors.RequestError(
                "pandas for a DataFrame",
                "none installed",
                "install it, or take as_dict()",
            ) from error
        return pandas.DataFrame([pose.as_dict() for pose in self.poses]).set_index(
            "index"
        )

    def __str__(self) -> str:
        """The table that commands print, each pose by itself."""
        return report(self, single_poses(self.poses))

    def _repr_html_(self) -> str:
        """The same table in a notebook."""
        return f"<pre>{escape(str(self))}</pre>"


def report(
    statistics: PoseStatistics,
    groups: Sequence[PoseGroup],
    part: Part | None = None,
    *,
    explain: bool = False,
) -> str:
    """The answer of one method as text, a row of its table for each group of poses.

    `part`: to describe its mesh, too; `explain`: whether to say why the method was
    chosen.
    """
    probabilities = probability_columns(groups, with_counts=statistics.drops > 0)
    lines = [
        heading(statistics, part),
        "",
        _method(statistics),
        "",
        *pose_table(groups, probabilities),
    ]
    if explain and statistics.choice:
        lines += ["", statistics.choice]
    return "\n".join(lines + remarks([statistics]))


def heading(statistics: PoseStatistics, part: Part | None = None) -> str:
    """Lines about the part and the scene."""
    poses = several(len(statistics.poses), "stable pose")
    groups = len({pose.group for pose in statistics.poses})
    if groups < len(statistics.poses):
        poses += f" in {several(groups, 'group')}"
    radius = statistics.radius
    if part is None:
        return (
            f"{statistics.part_id}: {statistics.scene}\n"
            f"{poses}, radius {radius * 1e3:.4g} mm"
        )
    center = np.round(part.center_of_mass / radius, 6) * radius * 1e3 + 0.0
    extents = np.ptp(part.surface_vertices, axis=0) * 1e3
    return (
        f"{part.part_id}: {statistics.scene}\n"
        f"{poses}, {len(part.triangles)} triangles, "
        f"{' x '.join(f'{x:.4g}' for x in extents)} mm\n"
        f"centre of mass ({', '.join(f'{x:.4g}' for x in center)}) mm, "
        f"radius {radius * 1e3:.4g} mm"
    )


def _method(statistics: PoseStatistics) -> str:
    """Lines about the method and its settings."""
    method = (
        f"method {statistics.method}, "
        f"cluster tolerance {statistics.cluster_tolerance:g}, "
    )
    error = 100.0 * statistics.expected_error
    largest = 100.0 * statistics.largest_error
    if not statistics.drops:
        return (
            f"{method}expected error {error:.1f} points (one pose: {largest:.1f}) "
            f"against drops at restitution {statistics.restitution:g}"
        )
    return (
        f"{statistics.drops} drops, {statistics.unsettled} unsettled, "
        f"seed {statistics.seed},\n"
        f"{method}expected error {error:.2f} points (one pose: {largest:.2f})"
    )


def remarks(answers: Sequence[PoseStatistics]) -> list[str]:
    """Lines for the end: warnings and notes of all answers, and how long they took."""
    warnings = dict.fromkeys(line for answer in answers for line in answer.warnings)
    notes = dict.fromkeys(f"note {line}" for answer in answers for line in answer.notes)
    seconds = sum(answer.seconds for answer in answers)
    duration = f"{seconds * 1e3:.3g} ms" if seconds < 1.0 else f"{seconds:.1f} s"
    return ["", *warnings, *notes, f"computed in {duration}"]


class Shares(NamedTuple):
    """What a method says of all poses (P,), by their index, and how sure it is."""

    probability: Array
    low: Array  # bounds of the 90 % intervals
    high: Array
    standard_error: Array
    counts: Index  # drops that came to rest, or parts that were seen; 0 for an estimate
    expected_error: float
    largest_error: float


def pose_statistics(
    part: Part,
    radius: float,
    poses: Iterable[StablePose],
    shares: Shares,
    method: str,
    scene: DropScene,
    *,
    knows_scene: bool = True,
    drops: int = 0,
    unsettled: int = 0,
    seed: int = 0,
    seconds: float = math.nan,
    warnings: Iterable[str] = (),
    notes: tuple[str, ...] = (),
) -> PoseStatistics:
    """Statistics of a part by a method.

    `radius`: of its body, metres; `poses`: all of them, by index; `knows_scene`:
    whether the method knows the drop height; `warnings`: beside those of the part.
    """
    scene_warnings = (
        height_warnings("drop", scene.drop_height, radius, HIGHEST_DROP)
        if knows_scene
        else []
    )
    release_height = scene.release_height(radius) if knows_scene else math.nan
    return PoseStatistics(
        part_id=part.part_id,
        part_digest=part.digest,
        radius=radius,
        method=method,
        **{**vars(scene), "drop_height": release_height},
        poses=rank_poses(poses, shares),
        drops=drops,
        unsettled=unsettled,
        seed=seed,
        expected_error=shares.expected_error,
        largest_error=shares.largest_error,
        seconds=seconds,
        warnings=(*part.warnings, *scene_warnings, *warnings),
        notes=(*part.notes, *notes),
        version=version.VERSION,
    )


def with_shares(
    model: PoseStatistics, method: str, shares: Shares, **changes: Any
) -> PoseStatistics:
    """The same part and scene by another method.

    `changes`: other fields that differ.
    """
    return replace(
        model,
        method=method,
        poses=rank_poses(model.by_index.values(), shares),
        expected_error=shares.expected_error,
        largest_error=shares.largest_error,
        **changes,
    )


def rank_poses(poses: Iterable[StablePose], shares: Shares) -> tuple[StablePose, ...]:
    """Poses with their shares and those of their groups, the most probable first.

    Those equal but for rounding stay in the order of their index.
    """
    columns = (column.tolist() for column in shares[:5])
    weighted_poses = [
        pose.with_values(
            probability=probability,
            probability_low=low,
            probability_high=high,
            standard_error=standard_error,
            count=count,
        )
        for pose, probability, low, high, standard_error, count in zip(
            poses, *columns, strict=True
        )
    ]
    group_sums: dict[int, float] = {}
    for pose in weighted_poses:
        group_sums[pose.group] = group_sums.get(pose.group, 0.0) + pose.probability
    rank = rank_probabilities(pose.probability for pose in weighted_poses)
    order = sorted(range(len(weighted_poses)), key=rank.__getitem__)
    return tuple(
        pose.with_values(group_probability=group_sums[pose.group])
        for pose in (weighted_poses[k] for k in order)
    )


def rank_probabilities(probabilities: Iterable[float]) -> list[int]:
    """Ranks by falling probability, NaN as 0; those equal but for rounding have one."""
    return tolerances.number_equal(
        [0.0 if math.isnan(share) else -share for share in probabilities],
        tolerances.SAME_SHARE,
    )
