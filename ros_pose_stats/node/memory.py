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

"""A bounded memory for several threads."""

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

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
        self._weights: dict[K, int] = {}  # a value may weigh more by now
        self._lock = threading.Lock()

    def get(self, key: K) -> V | None:
        """A value, which counts as used now; None where there is none."""
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
            return self._values.get(key)

    def peek(self, key: K) -> V | None:
        """A value, which does not count as used; None where there is none."""
        return self._values.get(key)

    @property
    def room(self) -> int:
        """By how much more the values may weigh."""
        return self._bound - self._sum

    def put(self, key: K, value: V) -> None:
        """Keep a value in place of the one before."""
        weight = self._weight(value)
        with self._lock:
            self._values[key] = value
            self._values.move_to_end(key)
            self._note_weight(key, weight)
            self._shrink()

    def drop(self, concerns: Callable[[K], bool]) -> None:
        """Forget the values of the keys that a question concerns."""
        with self._lock:
            for key in [key for key in self._values if concerns(key)]:
                self._forget(key)

    def weigh(self, turn: int, turns: int) -> None:
        """Weigh one of so many values again, which may have grown; others in turn."""
        with self._lock:
            values = list(self._values.items())[turn % turns :: turns]
        weights = {key: self._weight(value) for key, value in values}
        with self._lock:
            for key in weights.keys() & self._values.keys():
                self._note_weight(key, weights[key])
            self._shrink()

    def set_bound(self, bound: int) -> None:
        """Keep what weighs as much together from now on."""
        with self._lock:
            self._bound = bound
            self._shrink()

    def _note_weight(self, key: K, weight: int) -> None:
        self._sum += weight - self._weights.get(key, 0)
        self._weights[key] = weight

    def _shrink(self) -> None:
        while self._sum > self._bound and len(self._values) > 1:
            self._forget(next(iter(self._values)))

    def _forget(self, key: K) -> None:
        del self._values[key]
        self._sum -= self._weights.pop(key)
