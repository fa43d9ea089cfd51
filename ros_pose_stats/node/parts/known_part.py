"""A part that the node knows, and bounded memories."""

import math
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from ros_pose_stats_msgs.msg import PoseStatistics

from ...core.records import DropScene, Part

if TYPE_CHECKING:
    from .count_store import CellCounts

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class Memory(Generic[K, V]):
    """A bounded dictionary for several threads; the newest value stays, whatever its weight."""

    def __init__(self, most: int, weight: Callable[[V], int] = lambda value: 1) -> None:
        self._most = most
        self._weight = weight
        self._sum = 0
        self._values: OrderedDict[K, V] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: K) -> V | None:
        """A value, which counts as used now; None where there is none."""
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
            return self._values.get(key)

    def put(self, key: K, value: V) -> None:
        """Keep a value in place of the one before."""
        with self._lock:
            if key in self._values:
                self._sum -= self._weight(self._values.pop(key))
            self._values[key] = value
            self._sum += self._weight(value)
            while self._sum > self._most and len(self._values) > 1:
                self._sum -= self._weight(self._values.popitem(last=False)[1])


@dataclass(eq=False)
class Revisions:
    """Revisions of the results of one name, whichever meshes come under it."""

    newest: int = 0  # given to a result
    shown: int = 0  # of what was latched last
    # when a result went on record last, by the monotonic clock; what a start shows does not
    recorded_at: float = -math.inf
    # held while a result of the name is numbered, latched or withdrawn
    lock: threading.RLock = field(default_factory=threading.RLock)

    def next(self) -> int:
        """The number of a new result."""
        with self.lock:
            self.newest += 1
            return self.newest


@dataclass(eq=False)
class Shown:
    """What a part shows at a time."""

    latched: PoseStatistics  # which late joiners get
    # the best estimate or simulation for that scene, as it was before it was latched: under
    # another number, and combined with the counts where there are any
    model: PoseStatistics
    scene: DropScene  # that the latched result is for
    published: float = -math.inf  # when, by the monotonic clock
    recorded: bool = False  # whether it is in the bag


class PartSource:
    """Gives a part: the one at hand, or one that is built when somebody first asks for it."""

    def __init__(
        self, part: Part | None, build: Callable[[], Part] | None = None
    ) -> None:
        self._build = build
        self._lock = threading.Lock()
        self.part = part  # once it is at hand

    def get(self) -> Part:
        """The part, once it is built."""
        with self._lock:
            if self.part is None:
                assert self._build is not None
                self.part = self._build()
            return self.part


@dataclass(eq=False)
class KnownPart:
    """A part by its name; written by the part store."""

    part_id: str
    digest: str
    content: bytes  # digest of the mesh as it was sent
    scene_override: tuple[float, float]  # of the part's own scene; negative: the node's
    source: PartSource
    revisions: Revisions = field(default_factory=Revisions)  # of its name
    shown: Shown | None = None  # written by the result store
    counts: "CellCounts | None" = (
        None  # what cameras counted of it; written by the count store
    )
    size: int = (
        0  # bytes of the mesh as it is kept, and of the part when it became known
    )
    change: int = 0  # number of the change of the state that has it

    def model_in(self, scene: DropScene) -> PoseStatistics | None:
        """The model behind what is shown, where that is for this scene."""
        shown = self.shown
        return shown.model if shown is not None and shown.scene == scene else None

    @property
    def part(self) -> Part:
        """The part itself. Raises PoseStatsError if it cannot be built."""
        return self.source.get()


BUILT_BYTES = 64 * 2**20  # of parts that are kept because they may come again


def memory_of_parts() -> Memory[Any, Part]:
    """The latest parts by any key; what is prepared of one takes about as much as its mesh."""
    return Memory(
        BUILT_BYTES, lambda part: 2 * part.vertices.nbytes + 3 * part.triangles.nbytes
    )
