"""A bounded memory for several threads."""

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, Generic, TypeVar

from ..core.records import Part

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class Memory(Generic[K, V]):
    """A dictionary that forgets what was used least recently, never the newest."""

    def __init__(
        self, bound: int, weight: Callable[[V], int] = lambda value: 1
    ) -> None:
        self._bound = bound  # of the sum of all weights
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
            while self._sum > self._bound and len(self._values) > 1:
                self._sum -= self._weight(self._values.popitem(last=False)[1])


BUILT_BYTES = 64 * 2**20  # of parts that are kept because they may come again


def memory_of_parts() -> Memory[Any, Part]:
    """The latest parts by any key; what is prepared of one is as large as its mesh."""
    return Memory(
        BUILT_BYTES, lambda part: 2 * part.vertices.nbytes + 3 * part.triangles.nbytes
    )
