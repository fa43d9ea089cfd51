"""What parts the node knows: built once, kept in the state, the least recently used forgotten."""

import itertools
import threading
from collections import OrderedDict
from functools import partial

from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent

from ...base.errors import MeshError, PoseStatsError, RequestError
from ...core.records import Part, part
from ..equipment import Equipment
from ..lanes import NotDoneError
from ..messages import part_messages, part_requests, times
from ..recorder import JOB_EVENTS
from ..state import OF_PARTS, Change, Row
from . import part_builder
from .announcer import Announcer
from .known_part import KnownPart, Memory, PartSource, Revisions, memory_of_parts

NUMBERED = 1024  # forgotten parts whose revisions go on where they come again
REFUSED = 1024  # meshes whose refusals are remembered


class PartStore:
    """Known parts by their id."""

    def __init__(
        self,
        equipment: Equipment,
        announcer: Announcer,
        builder: part_builder.PartBuilder,
    ) -> None:
        self._settings = equipment.settings
        self._recorder = equipment.recorder
        self._state = equipment.state
        self._announcer = announcer
        self._builder = builder
        self._parts: OrderedDict[str, KnownPart] = OrderedDict()
        self._used: set[str] = set()
        self._uses = itertools.count(1)
        self._lock = threading.Lock()
        # also after another mesh of the same name has come
        self._built: Memory[tuple[str, bytes], Part] = memory_of_parts()
        self._refused: Memory[
            tuple[str, bytes], tuple[type[PoseStatsError], tuple[str, str, str]]
        ] = Memory(REFUSED)
        self._revisions: Memory[str, Revisions] = Memory(NUMBERED)

    def restore(self) -> None:
        """Know the parts of the state again, the last used ones; each is built when asked for."""
        rows = sorted(self._state.rows("parts"), key=lambda row: row[-1])
        with self._lock:
            for part_id, digest, content, restitution, drop_height, size, used in rows:
                source = PartSource(None, partial(self._rebuild, part_id, digest))
                self._parts[part_id] = KnownPart(
                    part_id,
                    digest,
                    content,
                    (restitution, drop_height),
                    source,
                    size=size,
                )
                self._uses = itertools.count(used + 1)
        self.shrink()

    def _rebuild(self, part_id: str, digest: str) -> Part:
        """Build a part of an earlier run; raises PoseStatsError."""
        message = self._state.mesh(part_id)
        if message is None:
            raise MeshError(
                f"the mesh of {part_requests.shown(part_id)} beside the state file",
                "none that is as it was written",
                "send the part again",
            )
        part = self._build(part_messages.request_of_part_bytes(message))
        if part.digest != digest:
            raise MeshError(
                f"the mesh of {part_requests.shown(part_id)} as it was stored",
                "another one",
                "send the part again",
            )
        return part

    def identify(self, request: part_requests.PartRequest) -> tuple[KnownPart, bool]:
        """The part that a mesh is, and whether it is to be `put`; raises PoseStatsError."""
        part_id = request.part_id
        content = request.content
        same = (
            self.find(part_id)
            if part_id
            else next(
                (
                    known
                    for known in self.all()
                    if known.content == content
                    and known.part_id == part.digest_name(known.digest)
                ),
                None,
            )
        )
        if same is None or same.content != content:
            built = self._build(request)
            part_id = built.part_id
            digest = built.digest
            source = PartSource(built)
        else:
            part_id = same.part_id
            digest = same.digest
            source = same.source
        old = self.find(part_id)
        override = request.scene_override
        if old is not None and (old.digest, old.scene_override) == (digest, override):
            return old, False
        of_name = self._revisions.get(part_id) if old is None else old.revisions
        return KnownPart(
            part_id, digest, content, override, source, of_name or Revisions()
        ), True

    def _build(self, request: part_requests.PartRequest) -> Part:
        key = request.part_id, request.content
        built = self._built.get(key)
        refusal = self._refused.get(key)
        if refusal is not None:
            kind, facts = refusal
            raise kind(
                *facts
            )  # anew, for the traceback of what is raised holds on to the mesh
        if built is None:
            try:
                built = self._builder.build(request)
            except NotDoneError:  # the mesh may be good
                raise
            except PoseStatsError as error:
                self._refused.put(key, error.__reduce__())
                raise
            self._built.put(key, built)
        return built

    def put(self, known: KnownPart, request: part_requests.PartRequest) -> None:
        """Keep a part in place of the last of its name, and of the oldest; raises MeshError."""
        known.size = part.array_bytes(known.part, request)
        most_bytes = self._settings().max_part_bytes
        if known.size > most_bytes:
            raise MeshError(
                f"a part that takes at most {most_bytes} bytes in memory (parameter "
                f"max_part_bytes)",
                f"{known.size} bytes, {len(known.part.triangles)} triangles",
                "decimate the mesh, or raise the parameter",
            )
        message = serialize_message(
            part_messages.part_message(
                request, known.part_id, request.stamp or times.now()
            )
        )
        with known.revisions.lock:
            other = self.current(known.part_id)
            if other is not None:
                self._announcer.introduce(other)
            gone = (
                []
                if other is None or other.digest == known.digest
                else [
                    Change(table, known.part_id, None) for table in ("counts", "flips")
                ]
            )
            known.change = self._state.put_mesh(
                known.part_id,
                message,
                Change("parts", known.part_id, self._row(known)),
                *gone,
            )
            self._announcer.introduce(known)
            with self._lock:
                self._parts.pop(known.part_id, None)
                self._parts[known.part_id] = known
        self.shrink()

    def _row(self, known: KnownPart) -> Row:
        return (
            known.part_id,
            known.digest,
            known.content,
            *map(float, known.scene_override),
            known.size,
            next(self._uses),
        )

    def keep_uses(self) -> None:
        """Have the state know which parts were used last."""
        with self._lock:
            used = self._used
            self._used = set()
            latest_last = [
                known for part_id, known in self._parts.items() if part_id in used
            ]
        for known in latest_last:
            with (
                known.revisions.lock
            ):  # another mesh, or none, may be about to take its place
                if self.current(known.part_id) is known:
                    self._state.put(Change("parts", known.part_id, self._row(known)))

    def find(self, part_id: str) -> KnownPart | None:
        """A part, which counts as used now; None if it is not known."""
        with self._lock:
            known = self._parts.get(part_id)
            if known is not None:
                self._parts.move_to_end(part_id)
                self._used.add(part_id)
            return known

    def current(self, part_id: str) -> KnownPart | None:
        """A part without counting it as used; None if it is not known."""
        with self._lock:
            return self._parts.get(part_id)

    def known(self, part_id: str) -> KnownPart:
        """A part, which counts as used now; raises RequestError if it is not known."""
        known = self.find(part_id)
        if known is None:
            with self._lock:
                names = sorted(self._parts)
            some = ", ".join(names[:8]) + (", …" if len(names) > 8 else "")
            raise RequestError(
                "the part_id of a known part" + (f" ({some})" if some else ""),
                part_requests.shown(part_id),
                "publish its mesh on ~/part_mesh, or send it to ~/estimate",
            )
        return known

    def all(self) -> list[KnownPart]:
        """All parts, the least recently used first."""
        with self._lock:
            return list(self._parts.values())

    def is_kept(self, known: KnownPart) -> bool:
        """Whether the state has a part on the disk; waits until it has."""
        return self._state.commit(known.change)

    def forget(
        self, known: KnownPart, why: str = "a client had the part forgotten"
    ) -> bool:
        """Forget a part; whether the state has that on the disk."""
        return self._state.commit(self._forget(known, why))

    def shrink(self) -> None:
        """Forget the least recently used ones beyond the bounds; the last is kept."""
        while True:
            settings = self._settings()
            with self._lock:
                total = sum(known.size for known in self._parts.values())
                if len(self._parts) < 2 or (
                    len(self._parts) <= settings.max_parts
                    and total <= settings.max_part_bytes
                ):
                    return
                oldest = next(iter(self._parts.values()))
            self._forget(
                oldest,
                "the part made room for others that were used more recently "
                "(parameters max_parts, max_part_bytes)",
            )

    def _forget(self, known: KnownPart, why: str) -> int | None:
        """Forget a part, unless another one has taken its place; the number of that change."""
        part_id = known.part_id
        stamp = times.now()
        with known.revisions.lock:  # no result of it is recorded meanwhile
            if self.current(part_id) is not known:
                return None
            self._announcer.withdraw_result(known, stamp, why)
            event = JobEvent(
                event=JobEvent.PART_FORGOTTEN, part_id=part_id, part_digest=known.digest
            )
            event.header.stamp = times.time_message(stamp)
            self._recorder.record(JOB_EVENTS, serialize_message(event))
            known.revisions.shown = known.revisions.newest
            self._revisions.put(part_id, known.revisions)
            with self._lock:
                self._parts.pop(part_id, None)
            return self._state.put(
                *(Change(table, part_id, None) for table in OF_PARTS)
            )
