"""What parts the node knows: built once, put on record once, the least recently used forgotten."""

from __future__ import annotations

import math
import threading
from collections import OrderedDict, deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import TypeVar

from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics

from ...errors import MeshError, PoseStatsError, RequestError
from ...records import DropScene, Part
from ...records.part import array_bytes, digest_name
from ..messages.times import now, time_message
from ..recorder import JOB_EVENTS, Recorder
from .cell_counts import CellCounts
from .memory import Memory
from .mesh_record import MeshRecord
from .part_builder import NotBuiltError
from .part_requests import PartRequest, part_of, shown

T = TypeVar("T")

REFUSED = 1024
"""Refused meshes kept for when they come again."""

BUILT_BYTES = 64 * 2**20
"""Of parts kept after another mesh of the same name has come: the first may come again."""

NUMBERED = 1024
"""Forgotten parts whose revisions go on where they come again."""

LAST_RECORDED = 16
"""Results of a name that are known to have been recorded: its meshes may change places."""


@dataclass(eq=False)
class Revisions:
    """Numbers of the results of one name, whichever meshes come under it."""

    newest: int = 0  # given to a result
    shown: int = 0  # of what was latched last
    # numbers of the last results that were put on record when latched, as they were first
    recorded: deque[int] = field(default_factory=lambda: deque(maxlen=LAST_RECORDED))
    recorded_at: float = -math.inf  # when that was last, by the monotonic clock
    # held while a result of the name is numbered, latched or withdrawn
    lock: threading.RLock = field(default_factory=threading.RLock)

    def next(self) -> int:
        """The number of a new result."""
        with self.lock:
            self.newest += 1
            return self.newest


@dataclass(eq=False)
class KnownPart:
    """A part with what the node says of it at present."""

    part: Part
    content: bytes  # digest of the mesh as it was sent
    scene_override: tuple[float, float]  # of the part's own scene; negative: the node's
    request: PartRequest | None = None  # the mesh as it was sent
    revisions: Revisions = field(default_factory=Revisions)  # of its name
    latched: PoseStatistics | None = None  # the current result, which late joiners get
    # the best estimate or simulation for that scene, as it was before it was latched: under
    # another number, and combined with the counts where there are any
    model: PoseStatistics | None = None
    counts: CellCounts | None = None  # what cameras counted of it
    scene: DropScene | None = None  # that the latched result is for
    published: float = 0.0  # when it was published, by the monotonic clock
    # the result of the last run that this one began with, which is in the bag already
    on_record: PoseStatistics | None = None
    # bytes of the mesh as it was sent, of the part, and of what was prepared on it when it became
    # known
    size: int = 0
    mark: int = -1  # the recorder's, when the latched result was put on record; -1 where it is not
    latched_bytes: int = 0  # size of the latched result as a message
    mesh_is_last: bool = False  # whether the mesh went on record, and no result of it since


def at_hand(value: T) -> Future[T]:
    """A future that is done."""
    future: Future[T] = Future()
    future.set_result(value)
    return future


class PartStore:
    """Known parts by their id.

    `on_forgotten`: told a part that made room or was forgotten, when (nanoseconds), and why.
    Attributes `build`: makes a `Part` of a `PartRequest`; `meshes`: which of their meshes are on
    record.
    """

    def __init__(self, recorder: Recorder,
                 on_forgotten: Callable[[KnownPart, int, str], object]) -> None:
        self._recorder = recorder
        self._on_forgotten = on_forgotten
        self.build: Callable[[PartRequest], Part] = part_of
        self._parts: OrderedDict[str, KnownPart] = OrderedDict()
        self._lock = threading.Lock()
        self._refused: Memory[tuple[str, bytes], PoseStatsError] = Memory(REFUSED)
        self._built: Memory[tuple[str, bytes], Part] = Memory(
            BUILT_BYTES, lambda part: 2 * part.vertices.nbytes + 3 * part.triangles.nbytes)
        self.meshes = MeshRecord(recorder)
        self._revisions: Memory[str, Revisions] = Memory(NUMBERED)

    def resolve(self, request: PartRequest) -> tuple[KnownPart, bool]:
        """The part that a mesh is, and whether it is new: not known yet, and here by `put` only.

        Raises PoseStatsError with one line that says what is wrong; at once where the mesh was
        refused before.
        """
        same = self._same(request.part_id, request.content)
        part = self._build(request) if same is None else same.part
        old = self.find(part.part_id)
        override = (request.restitution, request.drop_height)
        if old is not None and (old.part.digest, old.scene_override) == (part.digest, override):
            return old, False
        revisions = self._revisions.get(part.part_id) if old is None else old.revisions
        new = KnownPart(part, request.content, override, request, revisions or Revisions())
        if old is not None and old.part.digest == part.digest:
            new.counts = old.counts  # dropped otherwise, but on the same plate
        return new, True

    def _same(self, part_id: str, content: bytes) -> KnownPart | None:
        """The known part of this name and mesh; by the mesh alone where there is no name."""
        if part_id:
            known = self.find(part_id)
            return known if known is not None and known.content == content else None
        for known in self.all():
            if known.content == content and known.part.part_id == digest_name(known.part.digest):
                return self.find(known.part.part_id)
        return None

    def _build(self, request: PartRequest) -> Part:
        key = request.part_id, request.content
        refusal = self._refused.get(key)
        if refusal is not None:
            raise refusal
        part = self._built.get(key)
        if part is None:
            try:
                part = self.build(request)
            except NotBuiltError:  # the mesh may be good
                raise
            except PoseStatsError as found:
                self._refused.put(key, found)
                raise
            self._built.put(key, part)
        return part

    def put(self, known: KnownPart, most: int, most_bytes: int, *,
            newest: bool = True) -> KnownPart:
        """Record and remember a part, with no result of the same name between the two.

        It takes the place of one of the same id, if it is the newest, and of the oldest beyond
        `most` parts and `most_bytes` of them all. Returns the part that is known then.

        Raises MeshError if the part alone takes more.
        """
        known.size = array_bytes(known.part, known.request)
        if known.size > most_bytes:
            raise MeshError(f"a part that takes at most {most_bytes} bytes in memory (parameter "
                            f"max_part_bytes)", f"{known.size} bytes, "
                            f"{len(known.part.triangles)} triangles",
                            "decimate the mesh, or raise the parameter")
        with known.revisions.lock:
            self.meshes.record(known)
            with self._lock:
                other = self._parts.get(known.part.part_id)
                if other is not None and not newest:
                    return other
                self._parts.pop(known.part.part_id, None)
                self._parts[known.part.part_id] = known
            self.meshes.record(known)  # what held it may have gone while nobody knew the part
        self.shrink(most, most_bytes)
        return known

    def find(self, part_id: str) -> KnownPart | None:
        """A part, which counts as used now; None if it is not known."""
        with self._lock:
            known = self._parts.get(part_id)
            if known is not None:
                self._parts.move_to_end(part_id)
            return known

    def current(self, part_id: str) -> KnownPart | None:
        """A part without counting it as used; None if it is not known."""
        with self._lock:
            return self._parts.get(part_id)

    def known(self, part_id: str) -> KnownPart:
        """A part, which counts as used now.

        Raises RequestError if it is not known.
        """
        found = self.find(part_id)
        if found is None:
            with self._lock:
                names = sorted(self._parts)
            some = ", ".join(names[:8]) + (", …" if len(names) > 8 else "")
            raise RequestError("the part_id of a known part" + (f" ({some})" if some else ""),
                               shown(part_id), "publish its mesh on ~/part_mesh, or send the part "
                               "with the request")
        return found

    def all(self) -> list[KnownPart]:
        """All parts, the least recently used first."""
        with self._lock:
            return list(self._parts.values())

    def forget(self, part_id: str) -> None:
        """Forget a part.

        Raises RequestError if it is not known.
        """
        self._let_go(self.known(part_id), "a client had the part forgotten", durable=True)

    def shrink(self, most: int, most_bytes: int) -> None:
        """Forget the least recently used ones beyond `most` parts and bytes; one is kept."""
        while (oldest := self._oldest_beyond(most, most_bytes)) is not None:
            self._let_go(oldest, "the part made room for others that were used more recently "
                         "(parameters max_parts, max_part_bytes)", durable=False)

    def _oldest_beyond(self, most: int, most_bytes: int) -> KnownPart | None:
        with self._lock:
            total = sum(known.size for known in self._parts.values())
            too_many = len(self._parts) > most or total > most_bytes
            return next(iter(self._parts.values())) if too_many and len(self._parts) > 1 else None

    def record_forgotten(self, part_id: str, digest: str, stamp: int, *,
                         durable: bool = False) -> None:
        """Put on record that a part is not known any more, so that no later run begins with it."""
        event = JobEvent(event=JobEvent.PART_FORGOTTEN, part_id=part_id, part_digest=digest)
        event.header.stamp = time_message(stamp)
        self._recorder.record(JOB_EVENTS, serialize_message(event), durable=durable)

    def _let_go(self, known: KnownPart, why: str, *, durable: bool) -> None:
        """Forget a part, unless another one has taken its place.

        While its name is locked nothing is recorded of that: neither a result of it after the
        word that it is forgotten, nor that word after the same part has come again.
        """
        part_id, stamp = known.part.part_id, now()
        with known.revisions.lock:
            if self.current(part_id) is not known:
                return
            self._on_forgotten(known, stamp, why)
            self.record_forgotten(part_id, known.part.digest, stamp, durable=durable)
            known.revisions.shown = known.revisions.newest
            self._revisions.put(part_id, known.revisions)
            with self._lock:
                self._parts.pop(part_id, None)
