"""Stable poses and their probabilities, as every method answers."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from html import escape
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...base import errors, version
from .. import tolerances
from . import scene as scenes
from .part import Array, Index, Part
from .scene import DropScene
from .tables import report, single_poses

FORGOTTEN = "FORGOTTEN: "
"""Begins the warning of statistics without poses: their part is not known any more."""

POSE_FIELDS = (
    "index",
    "group",
    "group_size",
    "height",
    "top",
    "margin",
    "barrier",
    "spread",
    "rolls",
    "yaw_symmetry",
    "probability",
    "probability_low",
    "probability_high",
    "standard_error",
    "count",
    "group_probability",
)
"""Single values of a pose; JSON and messages have them under the same names."""

POSE_VECTORS = ("down", "roll_axis", "orientation")

UNITS = {
    "radius": "m",
    "drop_height": "m",
    "drop_height_low": "m",
    "drop_height_high": "m",
    "kick_height": "m",
    "seconds": "s",
    "max_seconds": "s",
    "height": "m",
    "top": "m",
    "barrier": "m",
    "position": "m",
    "margin": "rad",
    "spread": "rad",
    "per_minute": "1/min",
    "step": "m",
    "place": "m",
    "size": "m^2",
    "within": "m",
    "outline": "m",
    "center_shift": "m",
    "center_of_mass": "m",
    **dict.fromkeys(
        ("begin", "end", "time", "queued", "started", "ended", "forgotten"),
        "s since 1970",
    ),
}
"""By key, of what is no plain number, share or unit vector and has no unit in its key. A `step`
that has a `unit` beside it is in that one."""

NOTHING = 1e-14
"""Components this much smaller are rounding."""

STATISTICS_FIELDS = (
    "part_id",
    "part_digest",
    "radius",
    "method",
    "restitution",
    "drop_height",
    "cluster_tolerance",
    "round_sides",
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


class RestingShape(Protocol):
    """Contact polygon and silhouette of a part in one of its poses."""

    @property
    def support_polygon(self) -> Array:
        """Contact polygon (k, 2) in the plate frame, metres, counter-clockwise."""

    @property
    def outline(self) -> Array:
        """Convex silhouette (k, 2) in the plate frame, metres, counter-clockwise."""


@dataclass(frozen=True, eq=False)
class StablePose:
    """One stable pose of a part, with its resting probability.

    Attributes
    ----------
    index : int
        Number of the pose by geometry alone (rising height); equal for every method.
    group : int
        Shared by the poses that a proper rotation of the part carries into each other.
    down : (3,) array
        Unit vector in the part frame that points vertically down at rest.
    height : float
        Of the centre of mass above the plate, metres.
    top : float
        Of the highest point above the plate, metres.
    margin : float
        Smallest tilt of the plate that topples the part out of this pose, radians.
    barrier : float
        Rise of the centre of mass needed to leave the pose, metres; infinite for a single pose.
    spread : float
        Largest angle between the `down` of two members, radians.
    members : tuple of int
        The stable faces that are this pose, numbered by rising height over the whole part.
    orientation : (4,) array
        Quaternion x y z w of the part frame in the plate frame (smallest rotation).
    position : (3,) array
        Origin of the part frame in the plate frame, metres; the centre of mass is above (0, 0).
    shape : RestingShape
        Computes the contact polygon and the outline on demand.
    group_size : int
        Poses of its group.
    rolls : bool
        Whether it can be turned by 90 degrees about the axis of a round or toothed surface
        without rising by more than the cluster tolerance.
    roll_axis : (3,) array
        That axis on the plate, a unit vector of either sign; zero for none or several.
    yaw_symmetry : int
        Turns about the vertical that leave the part as it is: n-fold; 0 for any angle.
    probability : float
    probability_low, probability_high : float
        Bounds of the 90 % interval; NaN where none is known.
    standard_error : float
        NaN where none is known.
    count : int
        Drops that came to rest here; parts that were seen here where the method is `observed`.
    group_probability : float
        Of all poses of its group together.
    """

    index: int
    group: int
    down: Array
    height: float
    top: float
    margin: float
    barrier: float
    spread: float
    members: tuple[int, ...]
    orientation: Array
    position: Array
    shape: RestingShape = field(repr=False)
    group_size: int = 1
    rolls: bool = False
    roll_axis: Array = field(default_factory=lambda: np.zeros(3))
    yaw_symmetry: int = 1
    probability: float = math.nan
    probability_low: float = math.nan
    probability_high: float = math.nan
    standard_error: float = math.nan
    count: int = 0
    group_probability: float = math.nan

    @property
    def support_polygon(self) -> Array:
        """Contact polygon (k, 2) in the plate frame, metres, counter-clockwise from above."""
        return self.shape.support_polygon

    @property
    def outline(self) -> Array:
        """Silhouette (k, 2) of the hull in the plate frame, metres, counter-clockwise."""
        return self.shape.outline

    def with_values(self, **values: float) -> "StablePose":
        """The same pose with other probabilities."""
        pose = object.__new__(StablePose)
        pose.__dict__.update(self.__dict__, **values)
        return pose

    def as_dict(self) -> dict[str, Any]:
        """The pose as plain values under the keys of the JSON contract."""
        found: dict[str, Any] = plain(
            {
                **{name: getattr(self, name) for name in POSE_FIELDS},
                **{
                    name: without_rounding(getattr(self, name)) for name in POSE_VECTORS
                },
                "position": without_rounding(self.position, self.height),
                "members": self.members,
            }
        )
        return found


@dataclass(frozen=True, eq=False)
class PoseStatistics:
    """The stable poses of a part, most probable first, and how their probabilities were found.

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
        Root mean square over the poses against the model's own limit; NaN until measured.
    largest_error : float
        Bound that the error of every single pose keeps with 90 % confidence; NaN until measured.
    plate_error : float
        Expected root mean square, over groups of poses, against a real plate; no number of drops
        lowers it.
    seconds : float
        From mass properties to statistics, without reading files and imports.
    warnings : tuple of str
        What a person should act on, each `CODE: sentence`.
    notes : tuple of str
        What is peculiar about the part and asks for nothing, each `CODE: sentence`.
    version : str
        Of this package.
    round_sides : int
        Sides a turn of the polygons that round surfaces are taken as; 0: as in the file.
    observed : int
        Parts counted by cameras that the probabilities have learnt from; `count` of the poses
        are theirs then.
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
    plate_error: float = scenes.DEFAULT_PLATE_ERROR
    seconds: float = math.nan
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    version: str = ""
    choice: str = ""
    round_sides: int = 0
    observed: int = 0

    @property
    def scene(self) -> str:
        """How high the part was released, onto what, and how bouncy, in one sentence."""
        return scenes.describe_scene(self.restitution, self.drop_height)

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
        return report(self, single_poses(self))

    def _repr_html_(self) -> str:
        """The same table in a notebook."""
        return f"<pre>{escape(str(self))}</pre>"


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

    `radius`: of its body, metres; `poses`: all of them, by index; `knows_scene`: whether the
    method knows the drop height; `warnings`: beside those of the part.
    """
    suspect = (
        scenes.height_warnings("drop", scene.drop_height, radius, scenes.HIGHEST_DROP)
        if knows_scene
        else []
    )
    return PoseStatistics(
        part_id=part.part_id,
        part_digest=part.digest,
        radius=radius,
        method=method,
        restitution=scene.restitution,
        cluster_tolerance=scene.cluster_tolerance,
        drop_height=scene.release_height(radius) if knows_scene else math.nan,
        round_sides=scene.round_sides,
        poses=ranked(poses, shares),
        drops=drops,
        unsettled=unsettled,
        seed=seed,
        expected_error=shares.expected_error,
        largest_error=shares.largest_error,
        seconds=seconds,
        warnings=(*part.warnings, *suspect, *warnings),
        notes=(*part.notes, *notes),
        version=version.VERSION,
    )


def with_shares(
    model: PoseStatistics, method: str, shares: Shares, **changes: Any
) -> PoseStatistics:
    """The same part and scene by another method; `changes`: other fields that differ."""
    return replace(
        model,
        method=method,
        poses=ranked(model.by_index.values(), shares),
        expected_error=shares.expected_error,
        largest_error=shares.largest_error,
        **changes,
    )


def ranked(poses: Iterable[StablePose], shares: Shares) -> tuple[StablePose, ...]:
    """Poses by their index with their shares and those of their groups, the most probable first.

    Those equal but for rounding stay in the order of their index.
    """
    names = (
        "probability",
        "probability_low",
        "probability_high",
        "standard_error",
        "count",
    )
    columns = (column.tolist() for column in shares[:5])
    found = [
        pose.with_values(**dict(zip(names, values, strict=True)))
        for pose, *values in zip(poses, *columns, strict=True)
    ]
    together: dict[int, float] = {}
    for pose in found:
        together[pose.group] = together.get(pose.group, 0.0) + pose.probability
    rank = tolerances.number_equal(
        [0.0 if math.isnan(pose.probability) else -pose.probability for pose in found],
        tolerances.SAME_SHARE,
    )
    order = sorted(range(len(found)), key=rank.__getitem__)
    return tuple(
        found[k].with_values(group_probability=together[found[k].group]) for k in order
    )


def with_units(values: dict[str, Any]) -> dict[str, Any]:
    """The values as JSON takes them, and under `units` the units of those that have one."""
    found: dict[str, Any] = plain(values)
    keys = set(_keys(found))
    found["units"] = {key: unit for key, unit in UNITS.items() if key in keys}
    return found


def plain(value: Any) -> Any:
    """Numbers, strings, lists and dicts of whatever this was.

    JSON has no NaN and no infinity: they are None. -0 is 0, and named tuples are dicts.
    """
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    if isinstance(value, dict):
        return {name: plain(each) for name, each in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None
    return str(value) if isinstance(value, Path) else value


def without_rounding(vector: Array, scale: float = 0.0) -> Array:
    """A vector with 0 for what is rounding of its largest component, or of a `scale` above it."""
    least = NOTHING * max(scale, float(np.abs(vector).max()))
    return np.where(np.abs(vector) <= least, 0.0, vector)


def _keys(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        yield from (key for key in value if key != "step" or "unit" not in value)
    for each in value.values() if isinstance(value, dict) else value:
        if isinstance(each, (dict, list)):
            yield from _keys(each)
