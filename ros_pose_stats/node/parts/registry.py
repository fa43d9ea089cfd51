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

"""The parts that the node knows; those that were used least recently are forgotten.

Built parts leave memory before that, and are built again out of the state on demand.
"""

import itertools
import threading
from collections import OrderedDict
from dataclasses import replace
from functools import partial
from weakref import WeakValueDictionary

from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics
from visualization_msgs.msg import MarkerArray

from ...base.errors import MeshError, PoseStatsError
from ...core.mesh.parts import shift_center
from ...core.records import Array, Part
from ...core.records.part import digest_name, memory_bytes
from ..equipment import Equipment
from ..memory import Memory
from ..messages import part_messages, part_requests, times
from ..messages.codes import NotDoneError, UnknownPartError
from ..recorder import JOB_EVENTS
from ..refusals import Health
from ..state import OF_PARTS, Change
from .channel import LATCHED, NO_EVENTS, Channel
from .known_part import Commons, KnownPart
from .markers import markers_of
from .part_builder import PartBuilder
from .part_list import PartListing
from .part_source import PartKey, PartSource

NUMBERED = 1024  # forgotten parts whose revisions go on where they come again
REFUSED = 1024  # meshes whose refusals are remembered
SECONDS_BETWEEN = 1.0  # markers
WEIGHINGS = 30  # turns, one a second, in which all built parts are weighed again
GROWTH = 32  # times the bytes of its mesh that a built part may well take
SMALL_BYTES = 4096  # of a mesh; what is built of a smaller one takes as much


class PartRegistry:
    """Parts by their names; each is built once, and stored.

    The lock guards what is in the registry; who has it waits for no other lock.
    """

    def __init__(self, equipment: Equipment, builder: PartBuilder) -> None:
        self._equipment = equipment
        self._settings = equipment.settings
        self._state = equipment.state
        self._builder = builder
        self._commons = Commons(equipment, self.all)
        self._parts: OrderedDict[str, KnownPart] = OrderedDict()
        self._used_ids: set[str] = set()
        self._uses = itertools.count(1)
        self._lock = threading.Lock()
        # of present meshes, and what they were shifted to
        self._built_parts: Memory[PartKey, Part] = Memory(
            self._settings().max_part_bytes, memory_bytes
        )
        self._weighings = itertools.count()
        self._refusals: Memory[
            PartKey, tuple[type[PoseStatsError], tuple[str, str, str]]
        ] = Memory(REFUSED)
        # One of a name, as long as anybody has it.
        self._channels: WeakValueDictionary[str, Channel[KnownPart]] = (
            WeakValueDictionary()
        )
        self._forgotten_channels: Memory[str, Channel[KnownPart]] = Memory(NUMBERED)
        # until their farewell has had time to arrive
        self._closing_channels: list[Channel[KnownPart]] = []
        self._drawn_revisions: dict[str, int] = {}  # revisions in the markers, by part
        # So that its type is known before there is a part, which has its own publisher.
        self._advertisement = equipment.node.create_publisher(
            PoseStatistics, "~/pose_statistics", LATCHED, event_callbacks=NO_EVENTS
        )
        self.listing = PartListing(equipment, self._shown_parts)
        self._markers = equipment.node.create_publisher(
            MarkerArray, "~/markers", LATCHED
        )
        times.steady_timer(equipment.node, SECONDS_BETWEEN, self._look_after_topics)

    # Parts come.

    def restore(self) -> None:
        """Know the parts of the state again, to be built on demand."""
        rows = sorted(self._state.rows("parts"), key=lambda row: row[-1])
        for part_id, digest, content, restitution, drop_height, size, use in rows:
            part = self._make_part(
                part_id,
                digest,
                content,
                (restitution, drop_height),
                self._source(part_id, digest, content),
            )
            part.size = size
            part.is_current = True
            with self._lock:
                self._parts[part_id] = part
                self._uses = itertools.count(use + 1)
        self.shrink()

    def _make_part(
        self,
        part_id: str,
        digest: str,
        content: bytes,
        scene_override: tuple[float, float],
        source: PartSource,
    ) -> KnownPart:
        with self._lock:
            channel = self._channels.get(part_id)
            if channel is None:
                channel = Channel(self._equipment, self.listing.note_change)
                self._channels[part_id] = channel
        return KnownPart(
            self._commons, channel, part_id, digest, content, scene_override, source
        )

    def _source(self, part_id: str, digest: str, content: bytes) -> PartSource:
        """Where a part comes from whose mesh the state has, or is to have."""
        rebuild = partial(self._rebuild, part_id, digest)
        key = part_id, content
        return PartSource(self._built_parts, key, rebuild, self._state)

    def shift(self, part: KnownPart, offset: Array) -> KnownPart:
        """A built part with its centre shifted, (3,) metres; none of it is latched."""
        source = PartSource(
            self._built_parts,
            (part.part_id, part.content + offset.tobytes()),
            lambda _: shift_center(part.geometry, offset),
            self._state,
        )
        digest = source.get().digest
        return replace(
            part, digest=digest, source=source, latched=None, is_current=False
        )

    def has_room(self, part: KnownPart) -> bool:
        """Whether a part can be built with no other one that leaves memory."""
        return self._built_parts.room >= GROWTH * max(part.size, SMALL_BYTES)

    def _rebuild(self, part_id: str, digest: str, source: PartSource) -> Part:
        """Build a part out of the state; raises PoseStatsError."""
        name = part_requests.quote_text(part_id)
        message = source.mesh()
        if message is None:
            raise MeshError(
                f"the mesh of {name} beside the state file",
                "none that is as it was written",
                "send the part again",
            )
        part = self._build(part_messages.request_of_part_bytes(message))
        if part.digest != digest:
            raise MeshError(
                f"the mesh of {name} as it was stored",
                "another one",
                "send the part again",
            )
        return part

    def identify(self, request: part_requests.PartRequest) -> tuple[KnownPart, bool]:
        """The part that a mesh is, and whether it is new; raises PoseStatsError."""
        origin: KnownPart | Part | None = self._find_content(request)
        if origin is None:
            origin = self._build(request)
        part_id = origin.part_id
        digest = origin.digest
        content = request.content
        override = request.scene_override
        current = self.find(part_id)
        if current is not None and (current.digest, current.scene_override) == (
            digest,
            override,
        ):
            return current, False
        if isinstance(origin, KnownPart):
            source = origin.source
        else:
            source = self._source(part_id, digest, content)
            source.unstored = origin  # until the state has its mesh
        part = self._make_part(part_id, digest, content, override, source)
        return part, True

    def _find_content(self, request: part_requests.PartRequest) -> KnownPart | None:
        """The part that came of the same mesh under the same name, or without one."""
        if request.part_id:
            part = self.find(request.part_id)
            return (
                part if part is not None and part.content == request.content else None
            )
        for part in self.all():
            is_nameless = part.part_id == digest_name(part.digest)
            if is_nameless and part.content == request.content:
                return part
        return None

    def _build(self, request: part_requests.PartRequest) -> Part:
        mesh = request.part_id, request.content
        refusal = self._refusals.get(mesh)
        if refusal is not None:
            kind, facts = refusal
            # Anew, for the traceback of what is raised holds on to the mesh.
            raise kind(*facts)
        try:
            return self._builder.build(request)
        except NotDoneError:  # the mesh may be good
            raise
        except PoseStatsError as error:
            self._refusals.put(mesh, error.__reduce__())
            raise

    def put(self, part: KnownPart, request: part_requests.PartRequest) -> None:
        """Know and store a part in place of its name's last; raises MeshError."""
        message = serialize_message(
            part_messages.part_message(
                request, part.part_id, request.stamp or times.current_stamp()
            )
        )
        part.size = len(message)
        most_bytes = self._settings().max_part_bytes
        if part.size > most_bytes:
            raise MeshError(
                f"a mesh that takes at most {most_bytes} bytes (parameter "
                f"max_part_bytes)",
                f"{part.size} bytes, {len(request.triangles)} triangles",
                "decimate the mesh, or raise the parameter",
            )
        with part.lock:
            changes = [part.change_of_state(next(self._uses))]
            previous = self.current(part.part_id)
            if previous is not None:
                previous.introduce()
                if previous.digest != part.digest:
                    changes += previous.counts.removal()
                self._retire(previous)
            part.change = self._state.put_mesh(part.part_id, message, *changes)
            part.introduce()
            part.is_current = True
            part.source.attach()
            with self._lock:
                self._parts.pop(part.part_id, None)
                self._parts[part.part_id] = part
        self.shrink()

    # Parts are asked for.

    def find(self, part_id: str) -> KnownPart | None:
        """A part, which counts as used now; None if it is not known."""
        with self._lock:
            part = self._parts.get(part_id)
            if part is not None:
                self._parts.move_to_end(part_id)
                self._used_ids.add(part_id)
            return part

    def current(self, part_id: str) -> KnownPart | None:
        """A part without counting it as used; None if it is not known."""
        with self._lock:
            return self._parts.get(part_id)

    def require(self, part_id: str) -> KnownPart:
        """A part, which counts as used now; raises UnknownPartError."""
        part = self.find(part_id)
        if part is None:
            with self._lock:
                names = sorted(self._parts)
            full_name = self._equipment.node.full_name
            listed = ", ".join(names[:8]) + (", …" if len(names) > 8 else "")
            raise UnknownPartError(
                "the part_id of a known part" + (f" ({listed})" if listed else ""),
                part_requests.quote_text(part_id),
                f"publish its mesh on {full_name('part_mesh')}, or send it to "
                f"{full_name('estimate')}",
            )
        return part

    def all(self) -> list[KnownPart]:
        """All parts, the least recently used first."""
        with self._lock:
            return list(self._parts.values())

    def store_uses(self) -> None:
        """Have the state know which parts were used last."""
        with self._lock:
            used = [
                part
                for part_id, part in self._parts.items()
                if part_id in self._used_ids
            ]
            self._used_ids = set()
        for part in used:
            with part.lock:  # another mesh, or none, may be about to take its place
                if part.is_current:
                    self._state.put(part.change_of_state(next(self._uses)))

    # Parts go.

    def forget(
        self, part: KnownPart, reason: str = "a client had the part forgotten"
    ) -> bool:
        """Forget a part; whether the state has that on the disk."""
        return self._state.commit(self._forget(part, reason))

    def shrink(self) -> None:
        """Forget the least recently used ones beyond the bounds; the last is kept."""
        self._built_parts.set_bound(self._settings().max_part_bytes)
        while True:
            settings = self._settings()
            parts = self.all()
            total = sum(part.size for part in parts)
            if len(parts) < 2 or (
                len(parts) <= settings.max_parts and total <= settings.max_part_bytes
            ):
                return
            self._forget(
                parts[0],
                "the part made room for others that were used more recently "
                "(parameters max_parts, max_part_bytes)",
            )

    def _forget(self, part: KnownPart, reason: str) -> int | None:
        """Forget a part that is current still; the number of that change."""
        part_id = part.part_id
        stamp = times.current_stamp()
        channel = part.channel
        with part.lock:  # no result of it is recorded meanwhile
            if not part.is_current:
                return None
            part.withdraw_result(stamp, reason)
            event = JobEvent(part_forgotten=True, part_digest=part.digest)
            event.status.part_id = part_id
            event.header.stamp = times.time_message(stamp)
            self._equipment.recorder.record(JOB_EVENTS, serialize_message(event))
            channel.latched_revision = channel.newest_revision
            self._forgotten_channels.put(part_id, channel)
            self._retire(part)
            with self._lock:
                self._parts.pop(part_id, None)
                self._closing_channels.append(channel)
            return self._state.put(
                *(Change(table, part_id, None) for table in OF_PARTS)
            )

    def _retire(self, part: KnownPart) -> None:
        """Have a part, shifted or not, leave memory, before the state loses its mesh.

        Jobs may still be at work on it, or begin.
        """
        part.is_current = False
        part.source.detach()
        self._built_parts.drop(lambda key: key[0] == part.part_id)

    # All parts together.

    def name_plate(self, plate: str) -> bool:
        """Take counts of a nameless plate for this one's; whether the disk has that."""
        changes = []
        for part in self.all():
            with part.lock:
                changes += part.counts.name_plate(plate)
        return self._state.commit(self._state.put(*changes))

    def health_of_counts(self) -> Health:
        """The line about what cameras counted, and what has changed in that."""
        kinds = 0
        total = 0
        drifts = {}
        for part in self.all():
            tally = part.counts.tally
            if tally is not None:
                kinds += 1
                total += int(tally.total.sum())
                if tally.drift():
                    name = part_requests.quote_text(part.part_id)
                    drifts[f"changed {name}"] = tally.drift()
        line = f"{total} parts counted of {kinds} kinds"
        if drifts:
            line = ": ".join(next(iter(drifts.items())))
        values = {"kinds counted": kinds, "parts counted": total, **drifts}
        return Health(bool(drifts), line, values)

    def _shown_parts(self) -> list[KnownPart]:
        """Parts whose result is latched, by name."""
        with self._lock:
            parts = [channel.part for channel in self._channels.values()]
        return sorted(
            (part for part in parts if part is not None), key=lambda part: part.part_id
        )

    def _look_after_topics(self) -> None:
        """Let publishers go that have said farewell, list and draw what is new."""
        self.listing.catch_up()
        self._built_parts.weigh(next(self._weighings), WEIGHINGS)
        with self._lock:
            leaving = list(self._closing_channels)
        for channel in leaving:
            if channel.close():
                with self._lock:
                    self._closing_channels.remove(channel)
        rows = {}
        for part in self._shown_parts():
            if part.can_be_drawn and part.latched is not None:
                rows[part.part_id] = part.latched.message, part
        revisions = {
            part_id: message.revision for part_id, (message, _) in rows.items()
        }
        if revisions != self._drawn_revisions:
            self._drawn_revisions = revisions
            self._markers.publish(markers_of(list(rows.values())))
