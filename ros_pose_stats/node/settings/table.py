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

"""The node's parameters: a table, and a frozen snapshot of values that are checked."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence
from dataclasses import Field, dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from ...base.errors import RequestError
from ...base.methods import AT_ONCE, DEFAULT_METHOD
from ...core.records import DropScene
from ...core.records.scene import (
    DEFAULT_CLUSTER_TOLERANCE,
    DEFAULT_PLATE_ERROR,
    DEFAULT_RESTITUTION,
    DEFAULT_ROUND_SIDES,
    MOST_ROUND_SIDES,
)
from ..messages.part_requests import check_name, quote_text

if TYPE_CHECKING:
    from ...core.plates import PlateProfile

T = TypeVar("T")

MAX_INTEGER = 2**62
THREADS_A_CORE = 4  # more of them only wait for each other
MAX_TEXT = 500
BELOW_ONE = 1.0 - 1e-9
TOPIC = re.compile(r"(~/|/)?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)


def _parameter(default: T, description: str, *bounds: float, fixed: bool = False) -> T:
    """One row of the table: its type is the default's, and both bounds are allowed.

    A fixed one can be set at the start only.
    """
    return field(
        default=default,
        metadata={"description": description, "bounds": bounds, "fixed": fixed},
    )


@dataclass(frozen=True)
class Settings:
    """Parameters and their values at a time, which declaration and documents follow."""

    mesh_topics: tuple[str, ...] = _parameter(
        (),
        "Topics of type shape_msgs/Mesh to take parts from, each `topic` or "
        "`part_id=topic`; without a part_id the topic's last name is the part's.",
        fixed=True,
    )
    mesh_unit: float = _parameter(
        1.0, "Length of one unit of the meshes on mesh_topics, in metres.", 1e-9, 1e6
    )
    mesh_folders: tuple[str, ...] = _parameter(
        (),
        "Folders below which mesh_resource may name files as file:///FILE, links "
        "resolved; package://PACKAGE/FILE needs none within the package's share.",
        fixed=True,
    )
    plate_frame: str = _parameter("plate", "Frame of the plate in results and markers.")
    plate: str = _parameter(
        "",
        "Name of the plate, for the record; one of the file plates where that is "
        "named.",
    )
    plates: str = _parameter(
        "",
        "File of plate profiles (YAML, as ~/fit_plate and the command fit write it): "
        "while plate is named, its restitution, drop height and, where round parts "
        "gave them, round sides there take the place of the parameters, and its "
        "plate_error goes into results; empty: none.",
    )
    default_method: str = _parameter(
        DEFAULT_METHOD,
        "Estimator of the analytic answers; auto: the most accurate one at the "
        "restitution, and refinements combine drops with it.",
    )
    restitution: float = _parameter(
        DEFAULT_RESTITUTION,
        "Coefficient of restitution, 0 to below 1.",
        0.0,
        BELOW_ONE,
    )
    drop_height: float = _parameter(
        -1.0,
        "Height of the centre of mass above the plate at release, in metres; negative: "
        "20 part radii.",
        -1e6,
        1e6,
    )
    refine_drops: int = _parameter(
        0, "Background drops after each new mesh; 0: none.", 0, 10**9
    )
    drops: int = _parameter(
        10_000, "Drops of a simulation that does not say how many.", 1, 10**9
    )
    target_error: float = _parameter(
        0.0,
        "Root mean square error over the poses, as a fraction, to which each new mesh "
        "is refined in the background, until it is reached with 90 % confidence; "
        "0: none.",
        0.0,
        BELOW_ONE,
    )
    workers: int = _parameter(
        0,
        "Threads that simulate, at most four a core; 0: all cores but keep_cores, at "
        "least one.",
        0,
        256,
    )
    keep_cores: int = _parameter(1, "Cores that workers = 0 leaves to others.", 0, 1024)
    max_queued_jobs: int = _parameter(
        16, "Drop simulations that may wait; more are refused.", 0, 10**6
    )
    max_drops: int = _parameter(10_000_000, "Most drops of one simulation.", 1, 10**9)
    max_job_seconds: float = _parameter(
        600.0, "Most seconds of one simulation.", 0.001, 1e7
    )
    max_parts: int = _parameter(
        256, "Parts to remember; the least recently used is forgotten.", 1, 100_000
    )
    max_mesh_bytes: int = _parameter(
        64 * 2**20,
        "Most bytes of one mesh (8 a coordinate, 4 a vertex number).",
        1,
        MAX_INTEGER,
    )
    max_part_bytes: int = _parameter(
        2**30,
        "Most bytes of all meshes that the node keeps, of which the least recently "
        "used is forgotten, and of what is built of them in memory, of which the least "
        "recently used is built again when it is needed.",
        1,
        MAX_INTEGER,
    )
    cluster_tolerance: float = _parameter(
        DEFAULT_CLUSTER_TOLERANCE,
        "Least rise of the centre of mass out of a pose, as a share of its height "
        "there; what is shallower belongs to the pose next to it; 0: none.",
        0.0,
        BELOW_ONE,
    )
    round_sides: int = _parameter(
        DEFAULT_ROUND_SIDES,
        "Sides a turn of the polygons that stand for round surfaces, whatever the mesh "
        "has: 16 or more; 0: as the mesh has them.",
        0,
        MOST_ROUND_SIDES,
    )
    flip_height: float = _parameter(
        0.0,
        "Energy of a kick of the cell's feeder over the part's weight, in metres, "
        "where a request's kick_height is negative; 0: none.",
        0.0,
        1e6,
    )
    log_directory: str = _parameter(
        "", "Where bags are recorded; empty: ~/.ros/pose_stats.", fixed=True
    )
    max_bag_bytes: int = _parameter(
        512 * 2**20,
        "Bytes after which a bag goes on in a new file.",
        65536,
        MAX_INTEGER,
        fixed=True,
    )
    max_log_bytes: int = _parameter(
        2**33,
        "Most bytes of all bags in log_directory, the running one included: the oldest "
        "closed files are deleted; 0: unlimited.",
        0,
        MAX_INTEGER,
        fixed=True,
    )
    log_drops: bool = _parameter(False, "Record every single drop of the simulations.")
    restore: bool = _parameter(
        True, "Begin with the parts, results and counts of the state file.", fixed=True
    )
    state_file: str = _parameter(
        "",
        "SQLite file of what the node must not forget; empty: in log_directory, under "
        "the node's name.",
        fixed=True,
    )
    # what the file `plates` says of `plate`; no parameter itself
    profile: PlateProfile | None = None

    @property
    def plate_error(self) -> float:
        """Expected root mean square error against the plate itself, as a fraction."""
        return DEFAULT_PLATE_ERROR if self.profile is None else self.profile.plate_error

    def threads(self) -> int:
        """Threads around the kernels."""
        cores = len(os.sched_getaffinity(0))
        return min(self.workers, THREADS_A_CORE * cores) or max(
            1, cores - self.keep_cores
        )

    def directory(self) -> Path:
        """Where bags go."""
        return Path(self.log_directory or "~/.ros/pose_stats").expanduser()

    def state_path(self, node: str) -> Path:
        """The state file of a node, by its fully qualified name."""
        if self.state_file:
            return Path(self.state_file).expanduser()
        return self.directory() / f"{node.strip('/').replace('/', '.')}.sqlite3"

    def scene(self, *scene_override: tuple[float, float]) -> DropScene:
        """The scene: each value from the first of request, part, plate and node.

        A negative value in an override says nothing.
        """
        plate_scene = self.profile or self
        overrides = (
            *scene_override,
            (plate_scene.restitution, plate_scene.drop_height),
        )
        restitution = next(
            (r for r, _ in overrides if not r < 0.0), plate_scene.restitution
        )
        height = next((h for _, h in overrides if not h < 0.0), None)
        sides = (
            self.profile if self.profile and self.profile.tells_round_sides else self
        )
        return DropScene(restitution, height, self.cluster_tolerance, sides.round_sides)

    def kick(self, kick_height: float) -> float:
        """The kick of a request: its own, or the node's if it is negative; 0: none."""
        if not kick_height < math.inf:
            raise RequestError(
                "a kick_height in metres, 0 for none, or a negative one for the "
                "node's (parameter flip_height)",
                f"{kick_height}",
                "half the part's radius flips most parts",
            )
        return self.flip_height if kick_height < 0.0 else float(kick_height)


TABLE = {row.name: row for row in fields(Settings) if row.metadata}


def settings_of(values: dict[str, Any]) -> Settings:
    """Check values and freeze them.

    The file of plates is read where no `profile` is among them.
    """
    settings = Settings(**values)
    for setting in TABLE.values():
        _check(setting, getattr(settings, setting.name))
    if settings.default_method not in AT_ONCE:
        raise RequestError(
            f"default_method to be one of {', '.join(AT_ONCE)}",
            f"'{settings.default_method}'",
            f"{DEFAULT_METHOD} is the default",
        )
    mesh_topics(settings.mesh_topics)
    for folder in settings.mesh_folders:
        if not folder.startswith("/"):
            raise RequestError(
                "mesh_folders from the root on",
                quote_text(folder),
                "for instance /home/cell/meshes",
            )
    if "profile" not in values:
        settings = replace(
            settings, profile=find_profile(settings.plates, settings.plate)
        )
    replace(settings, profile=None).scene()
    for name in ("log_directory", "state_file"):
        try:
            Path(getattr(settings, name)).expanduser()
        except RuntimeError as error:
            raise RequestError(
                f"{name} to be a path",
                f"'{getattr(settings, name)}'",
                "there is no such user",
            ) from error
    return settings


def find_profile(plates: str, plate: str) -> PlateProfile | None:
    """Look a plate up in a file of plates.

    The file may be missing as long as no plate is named.
    """
    if not plates:
        return None
    # It takes a while to load, and few nodes need it.
    from ...core.plates import read_profiles

    remedy = (
        "leave the parameter plate empty until the service fit_plate or the command "
        "fit has written it there"
    )
    try:
        file = Path(plates).expanduser()
        if not plate and not file.exists():
            return None
        profiles = read_profiles(file)
    except RequestError as refusal:
        raise RequestError(
            f"plates: {refusal.expected}", refusal.finding, remedy
        ) from refusal
    except (OSError, RuntimeError) as error:
        # Of a name that is too long, or of a user that there is not.
        raise RequestError(
            "plates: a YAML file of plates",
            f"'{plates}' ({error})",
            "name a file that can be read",
        ) from error
    if plate and plate not in profiles:
        plate_names = ", ".join(map(quote_text, sorted(profiles))) or "none"
        raise RequestError(
            f"plate to be one of the plates in {file} ({plate_names})",
            quote_text(plate),
            remedy,
        )
    return profiles.get(plate)


def _check(setting: Field[Any], value: Any) -> None:
    """Refuse what is out of bounds, disturbs a terminal or is too long for answers."""
    low, high = setting.metadata["bounds"] or (value, value)
    if not low <= value <= high:
        top = "below 1" if high == BELOW_ONE else f"{high:g}"
        raise RequestError(
            f"{setting.name} from {low:g} to {top}",
            f"{value}",
            f"{setting.default!r} is the default",
        )
    for text in value if isinstance(value, tuple) else (value,):
        if isinstance(text, str) and (len(text) > MAX_TEXT or not text.isprintable()):
            raise RequestError(
                f"{setting.name} of at most {MAX_TEXT} printable characters",
                f"{len(text)} characters, {quote_text(text)}",
                "shorten it",
            )


def mesh_topics(entries: Sequence[str]) -> dict[str, str]:
    """Topics by the id of the part that comes on them; raises RequestError."""
    topics: dict[str, str] = {}
    for entry in entries:
        part_id, separator, topic = entry.rpartition("=")
        part_id = part_id if separator else topic.rpartition("/")[2]
        if not TOPIC.fullmatch(topic) or not part_id:
            raise RequestError(
                "mesh_topics as `topic` or `part_id=topic`",
                f"'{entry}'",
                "for instance bracket=/cad/bracket",
            )
        check_name(part_id)
        if part_id in topics:
            raise RequestError(
                "mesh_topics with a different part_id each",
                f"'{part_id}' for {topics[part_id]} and {topic}",
                "write part_id=topic",
            )
        topics[part_id] = topic
    return topics
