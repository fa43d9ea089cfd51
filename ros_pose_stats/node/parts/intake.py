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

"""The way of a mesh from a topic, a request or an earlier run to a result."""

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import TypeVar

from rclpy import callback_groups, event_handler, qos
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh

from ...base.errors import PoseStatsError
from ...core.mesh.bodies.overlap import TakesLongError
from ...core.records import DropScene, Part
from ...core.resting.poses import are_found
from ..equipment import Equipment
from ..lanes import Lane, Rank, finished_future
from ..messages import part_messages, part_requests
from ..messages.codes import NotDoneError, describe_error
from ..refusals import MESHES, SequenceGaps
from ..settings import Settings, mesh_topics
from . import part_builder
from .known_part import KnownPart
from .mesh_resources import read_resource
from .registry import PartRegistry

T = TypeVar("T")

DEPTH = 100  # messages that wait in the middleware
LARGE_BYTES = 24 * part_builder.LARGE_TRIANGLES  # of a mesh that is not built yet


class Intake:
    """Builds known parts in the lanes; `follow` gets each that shows something new."""

    def __init__(
        self,
        equipment: Equipment,
        parts: PartRegistry,
        builder: part_builder.PartBuilder,
        follow: Callable[[KnownPart], object],
    ) -> None:
        self._settings = equipment.settings
        self._lanes = equipment.lanes
        self._refusals = equipment.refusals
        self._parts = parts
        self._builder = builder
        self._follow = follow
        self._log = equipment.node.get_logger()
        # that wait to be shown in another scene, each once for all changes
        self._outdated: set[KnownPart] = set()
        # parts of an earlier run that had no result in the present scene
        self.restored: list[Future[None]] = []

    def _take(self, request: part_requests.PartRequest) -> KnownPart:
        """Know the part that a mesh is, and latch its result; raises PoseStatsError."""
        settings = self._settings()
        if request.resource:
            request = read_resource(
                request, settings.mesh_folders, settings.max_mesh_bytes
            )
        part_requests.check_request(request, settings.max_mesh_bytes)
        scene = settings.scene(request.scene_override)
        part, is_new = self._parts.identify(request)
        if is_new:
            geometry = part.geometry
            part.estimate("", scene)  # what has no equilibrium is no part
            self._parts.put(part, request)
            part.compare_counts(geometry)
            part.show_best()
            part.log_arrival(geometry)
            self._follow(part)
        return part

    def queue(
        self, request: part_requests.PartRequest, source: str, rank: Rank
    ) -> Future[KnownPart]:
        """Queue a mesh; waits for room where it is a small one that was published."""
        lane = _lane_of(request)
        self._log.debug(
            f"{source}: a mesh of {request.bytes()} bytes for the {lane.name} lane"
        )
        future = self._lanes.put(
            partial(self._take, request),
            rank,
            lane,
            request.bytes(),
            request.part_id,
        )
        self._refusals.watch_mesh(source, future)
        return future

    def build_known(
        self, part: KnownPart, scene: DropScene | None = None
    ) -> Future[Part]:
        """The known part itself, with poses in a scene; built before new ones.

        As long as somebody has it, `part.geometry` is at hand.
        """
        return self._with_geometry(part, scene, lambda geometry: geometry)

    def build_for_job(self, part: KnownPart) -> Future[KnownPart]:
        """A known part once it is built; it may leave memory before its job begins."""
        return self._with_geometry(part, None, lambda geometry: part)

    def _with_geometry(
        self, part: KnownPart, scene: DropScene | None, give: Callable[[Part], T]
    ) -> Future[T]:
        lane = _lane_of(part)
        built_part = part.source.part
        if built_part is not None and (
            scene is None or lane is Lane.QUICK or are_found(built_part, scene)
        ):
            return finished_future(give(built_part))

        def build() -> T:
            geometry = part.geometry
            if scene is not None:
                self._builder.find_poses(geometry, scene)
            return give(geometry)

        name = part.part_id if built_part is None else ""
        return self._lanes.put(build, Rank.KNOWN_PART, lane, 0, name)

    def show_all_again(self) -> None:
        """Show known parts in another scene, when nothing else waits."""
        for part in self._parts.all():
            if part in self._outdated:
                continue
            self._outdated.add(part)
            showing = self._lanes.put(
                partial(self._show_again, part), Rank.WHEN_IDLE, _lane_of(part)
            )
            self._refusals.watch_mesh("parameters", showing)

    def _show_again(self, part: KnownPart) -> None:
        self._outdated.discard(part)
        geometry = part.geometry
        self._builder.find_poses(geometry, self._settings().scene())
        part.compare_counts(geometry)
        part.show_best()
        self._follow(part)

    def restore(self) -> None:
        """Build parts of an earlier run when idle, first those without a result."""
        latest_first = self._parts.all()[::-1]
        for part in sorted(latest_first, key=lambda part: part.latched is not None):
            is_latched = part.latched is not None
            task = self._lanes.put(
                partial(self._build_again, part, is_latched),
                Rank.WHEN_IDLE,
                _lane_of(part),
            )
            if not is_latched:
                self.restored.append(task)

    def _build_again(self, part: KnownPart, is_latched: bool) -> None:
        """Build a part of an earlier run; one that is refused now goes."""
        if is_latched and not self._parts.has_room(part):
            return  # it is built on demand
        name = part_requests.name_suffix(part.part_id)
        try:
            part.source.get()
            if not is_latched:
                self._show_again(part)
            elif part.lacks_check():
                self._follow(part)
        except (TakesLongError, NotDoneError):
            raise
        except PoseStatsError as refusal:
            if part.is_current:  # else nobody wants it any more
                self._refusals.refuse(f"part of an earlier run{name}", str(refusal))
                self._parts.forget(part, f"it is refused now: {refusal}")
        except Exception as error:
            self._log.error(
                f"a part of an earlier run{name} could not be built: "
                f"{type(error).__name__}: {error}; a request tries again"
            )


def _lane_of(part: KnownPart | part_requests.PartRequest) -> Lane:
    """Where a mesh, or a known part that may not be built yet, is worked on."""
    if not isinstance(part, KnownPart):
        if part.resource:
            return Lane.FILE
        is_large = part_builder.is_large(part)
    else:
        geometry = part.source.part
        is_large = (
            part.size > LARGE_BYTES
            if geometry is None
            else part_builder.is_large(geometry)
        )
    return Lane.SLOW if is_large else Lane.QUICK


def subscribe_to_meshes(equipment: Equipment, intake: Intake) -> None:
    """Hand on what comes on `~/part_mesh` and on each of `mesh_topics`."""
    read_part = part_messages.request_of_part_bytes
    _subscribe(equipment, intake, PartMesh, "~/part_mesh", read_part)
    for part_id, topic in mesh_topics(equipment.settings().mesh_topics).items():
        read_mesh = partial(_read_mesh, equipment.settings, part_id)
        _subscribe(equipment, intake, Mesh, topic, read_mesh)


def _read_mesh(
    settings: Callable[[], Settings], part_id: str, data: bytes
) -> part_requests.PartRequest:
    return part_messages.request_of_mesh_bytes(data, part_id, settings().mesh_unit)


def _subscribe(
    equipment: Equipment,
    intake: Intake,
    kind: type,
    topic: str,
    read: Callable[[bytes], part_requests.PartRequest],
) -> None:
    """Plain and latched publishers of a topic both arrive; a copy is ignored later."""
    refusals = equipment.refusals
    gaps = SequenceGaps()

    def on_mesh(data: bytes) -> None:
        try:
            request = read(data)
        except Exception as error:  # a refusal, or a failure that is told like one
            refusals.refuse(full_topic, describe_error(error))
        else:
            source = full_topic + part_requests.name_suffix(request.part_id)
            intake.queue(request, source, Rank.PUBLISHED_MESH)

    def on_numbered_mesh(data: bytes, info: Mapping[str, int]) -> None:
        refusals.floods.count(f"meshes on {full_topic}")
        refusals.count_lost(MESHES, gaps.missing_before(info))
        on_mesh(data)

    group = callback_groups.MutuallyExclusiveCallbackGroup()
    full_topic = equipment.node.create_subscription(
        kind, topic, on_numbered_mesh, DEPTH, raw=True, callback_group=group
    ).topic_name
    # Plain publishers do not match this one; of what else is wrong with a publisher the
    # plain subscription warns.
    equipment.node.create_subscription(
        kind,
        topic,
        on_mesh,
        qos.QoSProfile(depth=DEPTH, durability=qos.DurabilityPolicy.TRANSIENT_LOCAL),
        raw=True,
        callback_group=group,
        event_callbacks=event_handler.SubscriptionEventCallbacks(
            incompatible_qos=lambda info: None
        ),
    )
