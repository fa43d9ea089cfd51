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

"""Where a part itself comes from: memory, or the state, out of which it is built."""

import threading
import weakref
from collections.abc import Callable

from ...core.records import Part
from ..memory import Memory
from ..state import State
from ..state.mesh_files import ReadMesh

PartKey = tuple[str, bytes]
"""The name of a part, and the digest of what makes it."""


class PartSource:
    """Gives a part: the one in memory, or one that is built when somebody asks."""

    def __init__(
        self,
        built_parts: Memory[PartKey, Part],
        key: PartKey,
        build: "Callable[[PartSource], Part]",
        state: State,
    ) -> None:
        self._built_parts = built_parts
        self._key = key
        self._build = build
        self._state = state
        self._building = threading.Lock()
        # a part that stays in memory, since the state has not its mesh, or has no more
        self.unstored: Part | None = None
        # what reads the mesh, once the state is to lose it, out of a file that is open
        # as long as somebody has this
        self._read: ReadMesh | None = None
        # the part that was there last, which who works on it may still have
        self._last: Callable[[], Part | None] = lambda: None

    @property
    def part(self) -> Part | None:
        """The part, where it is in memory, be it only since somebody works on it."""
        return self.unstored or self._built_parts.peek(self._key) or self._last()

    def get(self) -> Part:
        """The part, once built: no work for a callback, unless it has the part."""
        with self._building:
            part = self.unstored or self._built_parts.get(self._key)
            if part is None:
                part = self._last() or self._build(self)
                self._built_parts.put(self._key, part)
            self._last = weakref.ref(part)
            return part

    def mesh(self) -> bytes | None:
        """The mesh as a message, out of a file: no work for a callback either."""
        read = self._read
        if read is None:
            stored_mesh = self._state.mesh(self._key[0])
            read = self._read
            if read is None:
                return stored_mesh
        # The state has lost it, be it just now, and may have another one.
        return read()

    def detach(self) -> None:
        """Do without the state, which is to lose the mesh; reads nothing."""
        self.unstored = self.part
        self._read = self._state.open_mesh(self._key[0])

    def attach(self) -> None:
        """Let memory decide how long it has the part: the state has the mesh now."""
        if self.unstored is not None:
            self._built_parts.put(self._key, self.unstored)
            self._last = weakref.ref(self.unstored)
            self.unstored = None
        self._read = None
