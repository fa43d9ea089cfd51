"""The node's parameters: one table, and a frozen snapshot of their values."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import RequestError
from ..mesh.files import metres_per_unit
from ..methods import AT_ONCE, DEFAULT_METHOD
from ..records import DropScene
from ..records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_RESTITUTION
from .parts.mesh_topics import mesh_topics

MOST = 2**62


@dataclass(frozen=True)
class Setting:
    """One parameter.

    Attributes
    ----------
    name : str
    default : bool, int, float, str or list of str
        Its type is the parameter's.
    description : str
        With the unit.
    low, high : int or float, optional
        Bounds, both allowed.
    fixed : bool
        Can be set at the start only.
    """

    name: str
    default: Any
    description: str
    low: float | None = None
    high: float | None = None
    fixed: bool = False


BELOW_ONE = 1.0 - 1e-9

TABLE = (
    Setting("mesh_topics", [], "Topics of type shape_msgs/Mesh to take parts from, each `topic` "
            "or `part_id=topic`; without a part_id the topic's last name is the part's.",
            fixed=True),
    Setting("mesh_unit", 1.0, "Length of one unit of the meshes on mesh_topics, in metres.",
            1e-9, 1e6),
    Setting("plate_frame", "plate", "Frame of the plate in results and markers."),
    Setting("plate", "", "Name of the plate, for the record."),
    Setting("default_method", DEFAULT_METHOD, "Estimator of the analytic answers; auto: the most "
            "accurate one at the restitution, and refinements combine drops with it."),
    Setting("restitution", DEFAULT_RESTITUTION, "Coefficient of restitution, 0 to below 1.",
            0.0, BELOW_ONE),
    Setting("drop_height", -1.0, "Height of the centre of mass above the plate at release, in "
            "metres; negative: 20 part radii.", -1e6, 1e6),
    Setting("refine_drops", 0, "Background drops after each new mesh; 0: none.", 0, 10**9),
    Setting("drops", 10_000, "Drops of a simulation that does not say how many.", 1, 10**9),
    Setting("target_error", 0.0, "Error, as a fraction, to which each new mesh is refined in "
            "the background: with auto one kept with 90 % confidence, else the expected one; "
            "0: none.", 0.0, BELOW_ONE),
    Setting("workers", 0, "Threads that simulate; 0: all cores but keep_cores, at least one.",
            0, 1024),
    Setting("keep_cores", 1, "Cores that workers = 0 leaves to others.", 0, 1024),
    Setting("max_queued_jobs", 16, "Drop simulations that may wait; more are refused.", 0, 10**6),
    Setting("max_drops", 10_000_000, "Most drops of one simulation.", 1, 10**9),
    Setting("max_job_seconds", 600.0, "Most seconds of one simulation.", 0.001, 1e7),
    Setting("max_parts", 256, "Parts to remember; the least recently used is forgotten.",
            1, 100_000),
    Setting("max_mesh_bytes", 64 * 2**20, "Most bytes of one mesh (8 a coordinate, 4 a vertex "
            "number).", 1, MOST),
    Setting("cluster_tolerance", DEFAULT_CLUSTER_TOLERANCE, "Two poses merge where the saddle "
            "between them is less than this above both, as a fraction of the part's radius; "
            "0: none.", 0.0, BELOW_ONE),
    Setting("log_directory", "", "Where bags are recorded; empty: ~/.ros/pose_stats.",
            fixed=True),
    Setting("max_bag_bytes", 512 * 2**20, "Bytes after which a bag goes on in a new file.",
            65536, MOST, fixed=True),
    Setting("max_log_bytes", 0, "Most bytes of all bags in log_directory, the oldest closed runs "
            "being deleted; 0: unlimited.", 0, MOST, fixed=True),
    Setting("log_drops", False, "Record every single drop of the simulations."),
    Setting("restore", True, "Begin with the parts and results of the newest bag.", fixed=True),
)
BY_NAME = {setting.name: setting for setting in TABLE}


@dataclass(frozen=True)
class Settings:
    """Values of the parameters at one time; names as in `TABLE`."""

    mesh_topics: tuple[str, ...]
    mesh_unit: float
    plate_frame: str
    plate: str
    default_method: str
    restitution: float
    drop_height: float
    refine_drops: int
    drops: int
    target_error: float
    workers: int
    keep_cores: int
    max_queued_jobs: int
    max_drops: int
    max_job_seconds: float
    max_parts: int
    max_mesh_bytes: int
    cluster_tolerance: float
    log_directory: str
    max_bag_bytes: int
    max_log_bytes: int
    log_drops: bool
    restore: bool

    def threads(self) -> int:
        """Threads around the kernels."""
        cores = len(os.sched_getaffinity(0))
        return self.workers or max(1, cores - self.keep_cores)

    def directory(self) -> Path:
        """Where bags go."""
        return Path(self.log_directory or "~/.ros/pose_stats").expanduser()

    def scene(self, *scene_override: tuple[float, float]) -> DropScene:
        """The scene of the first that has a say: request, part, node.

        Parameters
        ----------
        *scene_override : (restitution, drop_height)
            Negative where there is none.

        Raises
        ------
        RequestError
            If a value is out of its range.
        """
        ladder = (*scene_override, (self.restitution, self.drop_height))
        restitution = next((r for r, _ in ladder if not r < 0.0), self.restitution)
        height = next((h for _, h in ladder if not h < 0.0), None)
        return DropScene(restitution, height, self.cluster_tolerance)


def settings_of(values: dict[str, Any]) -> Settings:
    """Check values and freeze them.

    Parameters
    ----------
    values : dict
        One of each name in `TABLE`, of the right types.

    Raises
    ------
    RequestError
        With the parameter, the value and the bound.
    """
    for setting in TABLE:
        _check_bounds(setting, values[setting.name])
    method = values["default_method"]
    if method not in AT_ONCE:
        raise RequestError(f"default_method to be one of {', '.join(AT_ONCE)}", f"'{method}'",
                           f"{DEFAULT_METHOD} is the default")
    metres_per_unit(values["mesh_unit"])
    mesh_topics(values["mesh_topics"])
    settings = Settings(**{**values, "mesh_topics": tuple(values["mesh_topics"])})
    settings.scene()
    try:
        settings.directory()
    except RuntimeError as error:
        raise RequestError("log_directory to be a folder", f"'{settings.log_directory}'",
                           "there is no such user") from error
    return settings


def _check_bounds(setting: Setting, value: Any) -> None:
    low, high = setting.low, setting.high
    if low is not None and high is not None and not low <= value <= high:
        top = "below 1" if high == BELOW_ONE else f"{high:g}"
        raise RequestError(f"{setting.name} from {low:g} to {top}", f"{value}",
                           f"{setting.default!r} is the default")
