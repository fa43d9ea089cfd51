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

"""A rigid part: the mesh as received, the repaired surface and the mass properties."""

import hashlib
import sys
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...base import errors
from .notes import Note, has_note

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]
Corners = NDArray[np.integer]  # of triangles: numbers of vertices

Prepared = TypeVar("Prepared")

OWNER_BYTES = 160  # of what has the memory of an array that has not its own


def part_digest(
    vertices: Array,
    triangles: NDArray[np.uint32],
    mass: float,
    center_of_mass: Array,
    inertia: Array,
) -> str:
    """SHA-256 (hex) that identifies a part.

    Over little-endian float64 vertices as received, in metres, uint32 triangles, and
    float64 mass, centre of mass and inertia (row by row) as used.
    """
    digest = hashlib.sha256(np.ascontiguousarray(vertices, dtype="<f8").data)
    digest.update(np.ascontiguousarray(triangles, dtype="<u4").data)
    digest.update(np.asarray([mass], dtype="<f8").data)
    digest.update(np.ascontiguousarray(center_of_mass, dtype="<f8").data)
    digest.update(np.ascontiguousarray(inertia, dtype="<f8").data)
    return digest.hexdigest()


def digest_name(digest: str) -> str:
    """Name of a part that was given none."""
    return f"mesh_{digest[:12]}"


def memory_bytes(value: object) -> int:
    """Bytes of memory that a value takes with its fields and items, each once."""
    stack = [value]
    counted_ids = set()
    total = 0
    while stack:
        value = stack.pop()
        if id(value) in counted_ids:
            continue
        counted_ids.add(id(value))
        total += sys.getsizeof(value)
        if isinstance(value, np.ndarray):
            owner: object = value.base
            if isinstance(owner, np.ndarray):
                stack.append(owner)
            elif owner is not None:  # a kernel's, or out of another process
                total += value.nbytes + OWNER_BYTES
        elif isinstance(value, (tuple, list)):
            stack += value
        elif isinstance(value, dict):
            stack += value.values()
        elif hasattr(value, "__dict__"):
            stack.append(vars(value))
    return total


@dataclass(frozen=True, eq=False, repr=False)
class Part:
    """A rigid part in its own frame, SI units.

    Attributes
    ----------
    part_id : str
        Name for people; `mesh_` and twelve digits of the digest when none was given.
    vertices : (V, 3) array, read-only
        Metres, as received.
    triangles : (T, 3) array of uint32, read-only
        As received.
    surface_vertices : (W, 3) array, read-only
        Metres; vertices welded.
    surface_triangles : (U, 3) array of int64, read-only
        Closed surface with normals pointing out of the material (the convex hull's when
        the mesh was open).
    mass : float
        Kilograms; 1 when nothing was given.
    center_of_mass : (3,) array, read-only
        Metres.
    inertia : (3, 3) array, read-only
        About the centre of mass in part axes, kg m².
    warnings : tuple of Note
        What a person should know of it.
    rounding : float
        Metres by which the coordinates may be off for having been stored as float32 or
        float64; grows with the distance from the origin.
    unit : float
        Metres a unit of the file or the arrays, as they came.
    unit_guessed : bool
        Whether that is a guess from the size, since the file names none.
    bodies : int
        Bodies that stood apart in the mesh as it came, of which the part is one; 1
        where it is the whole mesh.
    error_known : bool
        Whether answers may tell an error; False where the convex hull was accepted for
        a solid that came out open.
    digest : str
        See `part_digest`.
    """

    part_id: str
    vertices: Array
    triangles: NDArray[np.uint32]
    surface_vertices: Array
    surface_triangles: Index
    mass: float
    center_of_mass: Array
    inertia: Array
    warnings: tuple[Note, ...] = ()
    rounding: float = 0.0
    digest: str = field(init=False, compare=False)
    unit: float = 1.0
    unit_guessed: bool = False
    bodies: int = 1
    error_known: bool = True
    _prepared: dict[Hashable, Any] = field(
        default_factory=dict, init=False, compare=False
    )

    def __post_init__(self) -> None:
        self._freeze()
        object.__setattr__(
            self,
            "digest",
            part_digest(
                self.vertices,
                self.triangles,
                self.mass,
                self.center_of_mass,
                self.inertia,
            ),
        )
        if not self.part_id:
            object.__setattr__(self, "part_id", digest_name(self.digest))

    @property
    def is_open(self) -> bool:
        """Whether the convex hull stands in for the surface of an open mesh."""
        return has_note(self, "OPEN_MESH")

    def require_known_error(self, answer: str) -> None:
        """Refuse an answer, in words, that is nothing without its error."""
        if not self.error_known:
            raise errors.RequestError(
                f"a closed surface for {answer}",
                "the hull of an open solid, whose error nobody knows",
                "export the part again, or heal it in CAD",
            )

    def prepare(self, make: Callable[..., Prepared], *options: Hashable) -> Prepared:
        """Return what a function makes of the part.

        It is made once and lives as long as the part.

        What it returns must not refer to the part. Two threads that ask first at the
        same time may both make it; their results are equal.
        """
        key = (make, *options)
        prepared: Prepared | None = self._prepared.get(key)
        if prepared is None:
            prepared = self._prepared[key] = make(self, *options)
        return prepared

    def all_prepared(self) -> dict[Hashable, Any]:
        """All that is kept, for the same part in another process."""
        return dict(self._prepared)

    def keep_all(self, prepared: Mapping[Hashable, Any]) -> None:
        """Take over, by function and options, what `prepare` made elsewhere."""
        self._prepared.update(prepared)

    def has_prepared(self, make: Callable[..., object], *options: Hashable) -> bool:
        """Whether `prepare` would answer at once."""
        return (make, *options) in self._prepared

    def __repr__(self) -> str:
        return (
            f"Part({self.part_id!r}, {len(self.triangles)} triangles, {self.mass:g} "
            f"kg, digest {self.digest[:12]}…)"
        )

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "_prepared": {}}  # prepared anew where it is needed

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        self._freeze()

    def _freeze(self) -> None:
        """Make the arrays read-only, since the digest stands for them."""
        for name in (
            "vertices",
            "triangles",
            "surface_vertices",
            "surface_triangles",
            "center_of_mass",
            "inertia",
        ):
            getattr(self, name).flags.writeable = False
