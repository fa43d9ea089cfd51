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

"""Stable poses and their probabilities, as every method answers and commands print."""

import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from ...base import errors, text
from ...base.text import Column, several
from .notes import Note, note_lines
from .part import Array, Part
from .plain_values import with_units
from .poses import PoseGroup, StablePose, lookalikes, single_poses
from .scene import DEFAULT_PLATE_ERROR, SCENE_FIELDS, Numbering, describe_scene

STATISTICS_FIELDS = (
    "part_id",
    "part_digest",
    "radius",
    "bodies",
    "unit",
    "unit_guessed",
    "method",
    *SCENE_FIELDS,
    "drops",
    "unsettled",
    "seed",
    "counted_parts",
    "model_gap",
    "expected_error",
    "largest_error",
    "plate_error",
    "version",
)
"""Single values of statistics, as in JSON and in messages."""


BAR = 12  # characters of a full bar
MOST_INDICES = 20  # characters for the indices of the poses of a row
UNKNOWN = "-"  # how columns write a value that is not known
ALIKE = (
    "  alike: poses of the same silhouette from above; a camera may take them for each "
    "other"
)
ROLLING = "  * rolls in this pose; the tilt to topple holds across its axis only"


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
    warnings : tuple of Note
        What a person should know; `acts` says whether to do something before relying
        on the answer.
    version : str
        Of this package.
    round_sides : int
        Sides a turn of the polygons that round surfaces are taken as; 0: as in the
        file.
    counted_parts : int
        Parts counted by cameras that the probabilities have learnt from; `count` of the
        poses are theirs then.
    model_gap : float
        Root mean square over the poses between the probabilities of the model and the
        shares that were counted, 0 to 1; NaN where nothing was counted.
    choice : str
        Why this method was chosen, in one sentence; empty where the caller chose it.
    bodies : int
        Bodies that stood apart in the part's file, arrays or message, of which the part
        is one; 1 where it is the whole mesh; 0: not known.
    unit : float
        Metres a unit of the part's file, arrays or message, as they came; 0: not known.
    unit_guessed : bool
        Whether that is a guess from the part's size, since its file names none.
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
    warnings: tuple[Note, ...] = ()
    version: str = ""
    choice: str = ""
    round_sides: int = 0
    counted_parts: int = 0
    model_gap: float = math.nan
    unit: float = 0.0
    unit_guessed: bool = False
    bodies: int = 0

    @property
    def scene(self) -> str:
        """How high the part was released, onto what, and how bouncy, as a sentence."""
        return describe_scene(self.restitution, self.drop_height)

    @property
    def numbering(self) -> int:
        """Under which number the poses have their `index`: 64 bits, equal for equal.

        See `Numbering.code`.
        """
        numbering = Numbering(self.cluster_tolerance, self.round_sides)
        return numbering.code(self.part_digest)

    def as_dict(self) -> dict[str, Any]:
        """The statistics as plain values under the keys of the JSON contract."""
        fields = (
            *STATISTICS_FIELDS,
            "numbering",
            "seconds",
            "choice",
            "scene",
            "warnings",
        )
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

    def column(self, name: str) -> Any:
        """A single value of all poses, by their `index`.

        Parameters
        ----------
        name : str
            Of an attribute of `StablePose` that is a number.

        Returns
        -------
        (P,) array
        """
        return np.array([getattr(pose, name) for pose in self.by_index.values()])

    def transforms(self) -> tuple[Array, Array]:
        """The poses as `trimesh.poses.compute_stable_poses` returns them.

        Returns
        -------
        transforms : (n, 4, 4) array
            What takes points of the part frame to the plate frame, metres: the part
            rests on z = 0, its centre of mass above the origin. Most probable first.
        probabilities : (n,) array
        """
        matrices = [pose.transform for pose in self.poses]
        return (
            np.array(matrices).reshape(-1, 4, 4),
            np.array([pose.probability for pose in self.poses]),
        )

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


def require_same_part(statistics: object, part: object) -> None:
    """Refuse statistics that are not of a part."""
    if not isinstance(statistics, PoseStatistics):
        got = type(statistics).__name__
    elif not isinstance(part, Part) or part.digest != statistics.part_digest:
        got = f"those of {statistics.part_id}"
    else:
        return
    raise errors.RequestError(
        "statistics of the part", got, "estimate the part that is given"
    )


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
    counts = "counted" if statistics.counted_parts else "drops"
    has_counts = bool(statistics.drops or statistics.counted_parts)
    probabilities = probability_columns(groups, counts if has_counts else "")
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


def heading(statistics: PoseStatistics, part: Part | None) -> str:
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
    largest = 100.0 * statistics.largest_error
    digits = 2 if statistics.drops or statistics.counted_parts else 1
    error = "error not known"
    if not math.isnan(statistics.expected_error):
        error = (
            f"expected error {100.0 * statistics.expected_error:.{digits}f} points "
            f"(one pose: {largest:.{digits}f})"
        )
    if statistics.counted_parts:
        counted = several(statistics.counted_parts, "part")
        return f"{counted} counted on the plate,\n{method}{error} against the plate"
    if not statistics.drops:
        return (
            f"{method}{error} against drops at restitution {statistics.restitution:g}"
        )
    return (
        f"{statistics.drops} drops, {statistics.unsettled} unsettled, "
        f"seed {statistics.seed},\n{method}{error}"
    )


def remarks(answers: Sequence[PoseStatistics]) -> list[str]:
    """Lines for the end: warnings of all answers, and how long they took."""
    warnings = note_lines(warning for answer in answers for warning in answer.warnings)
    seconds = sum(answer.seconds for answer in answers)
    duration = f"{seconds * 1e3:.3g} ms" if seconds < 1.0 else f"{seconds:.1f} s"
    return ["", *warnings, f"computed in {duration}"]


class FilledColumn(NamedTuple):
    """A column of a table with its cells."""

    head: Column
    cells: list[str]


RARE = 1e-3
"""Probability below which poses are folded into one line of a table."""


def listed_groups(groups: Sequence[PoseGroup]) -> Sequence[PoseGroup]:
    """Those of groups in falling order that a table lists: none that is rare."""
    common = sum(not group.probability < RARE for group in groups)  # or not known
    return groups[: min(common, text.MOST_POSES)]


def pose_table(
    groups: Sequence[PoseGroup], probabilities: Iterable[FilledColumn]
) -> list[str]:
    """Lines about groups of poses; the rare ones, and very many, are summed up in one.

    `probabilities`: columns for the middle of the table, of the `listed_groups`.
    Columns in which nothing is known are left out.
    """
    listed = listed_groups(groups)
    poses = [group.first for group in listed]
    are_joined = any(group.size > 1 for group in listed)
    sizes = [str(group.size) if are_joined else UNKNOWN for group in listed]
    rolls = any(pose.rolls for pose in poses)
    alike_poses = [lookalikes(group, groups) for group in listed]

    columns = [
        FilledColumn(
            Column("poses" if are_joined else "pose"),
            [_indices(group.indices) for group in listed],
        ),
        FilledColumn(Column("number"), sizes),
        FilledColumn(Column("group"), [str(pose.group) for pose in poses]),
        FilledColumn(
            Column("alike"), [_indices(indices) or UNKNOWN for indices in alike_poses]
        ),
        *probabilities,
        FilledColumn(
            Column("height", "mm"), [text.millimetres(pose.height) for pose in poses]
        ),
        FilledColumn(
            Column("barrier", "mm"),
            [text.millimetres(group.barrier) for group in listed],
        ),
        FilledColumn(
            Column("topple", "deg"), [_topple(group, rolls) for group in listed]
        ),
        FilledColumn(
            Column("down", left=True), [_direction(pose.down) for pose in poses]
        ),
    ]
    # The column of barriers stays for a single pose, which has none.
    columns = [
        column
        for column in columns
        if column.head.title == "barrier" or set(column.cells) != {UNKNOWN}
    ]
    lines = text.columns(
        [column.head for column in columns],
        list(zip(*(column.cells for column in columns), strict=True)),
    )

    unlisted = groups[len(listed) :]
    if unlisted:
        poses_unlisted = sum(group.size for group in unlisted)
        share = _percent(sum(group.probability for group in unlisted)).strip()
        bound = f" below {100.0 * RARE:g} %" if unlisted[0].probability < RARE else ""
        lines.append(
            f"... and {text.several(poses_unlisted, 'more pose')}{bound}, "
            f"{share} together; --json lists all"
        )
    if any(alike_poses):
        lines.append(ALIKE)
    if rolls:
        lines.append(ROLLING)
    return lines


def probability_columns(
    groups: Sequence[PoseGroup], counts: str = ""
) -> list[FilledColumn]:
    """Probabilities of the listed groups, their intervals, and counts.

    `counts`: the head of their column; empty where nothing was counted.
    """
    listed = listed_groups(groups)
    return [
        FilledColumn(
            Column("probability", left=True),
            [
                f"{_percent(group.probability)} {_bar(group.probability)}"
                for group in listed
            ],
        ),
        FilledColumn(
            Column("90 % interval", "%"),
            [
                text.interval(group.probability_low, group.probability_high)
                for group in listed
            ],
        ),
        FilledColumn(
            Column(counts),
            [str(group.count) if counts else UNKNOWN for group in listed],
        ),
    ]


def _indices(indices: Sequence[int]) -> str:
    """Indices of poses; the last ones are left out of a long list."""
    listed = text.ranges(indices)
    if len(listed) <= MOST_INDICES:
        return listed
    return f"{listed[:MOST_INDICES].rpartition(',')[0]}, ..."


def _topple(group: PoseGroup, is_marked: bool) -> str:
    """The tilt that topples a group, with room for the mark of those that roll."""
    tilt = text.degrees(group.margin)
    if not is_marked:
        return tilt
    return tilt + (" *" if group.first.rolls else "  ")


def _direction(vector: Array) -> str:
    return "(" + ", ".join(f"{x + 0.0:+.3f}" for x in np.round(vector, 3)) + ")"


def _percent(probability: float) -> str:
    return f"{100.0 * probability:6.2f}%"


def _bar(probability: float) -> str:
    """A bar in the characters that the terminal can write."""
    # The encoding is None where standard output is closed.
    encoding = (getattr(sys.stdout, "encoding", None) or "ascii").lower()
    probability = 0.0 if math.isnan(probability) else probability
    # No tie of 1/8 or 1/12, which rounding would decide.
    eighths = round(8 * BAR * probability)
    if encoding.startswith("utf"):
        bar = "█" * (eighths // 8) + " ▏▎▍▌▋▊▉"[eighths % 8]
    else:
        bar = "#" * ((eighths + 4) // 8)
    return bar.ljust(BAR)[:BAR]
