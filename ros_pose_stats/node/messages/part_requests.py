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

"""A part as a client sends it, without its message, checked as far as is cheap."""

import hashlib
import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...base.errors import MeshError, RequestError
from ...base.methods import AT_ONCE, AUTO
from ...core.estimators import best_method
from ...core.mesh.bodies import separation
from ...core.mesh.parts import part_from_mesh
from ...core.records import Array, Part

MAX_NAME = 200
MAX_QUOTED = 40


@dataclass(frozen=True, eq=False)
class PartRequest:
    """A mesh on its way to become a `Part`."""

    part_id: str  # empty: named by its digest
    vertices: Array  # (V, 3); in `unit`; may be a view on a received buffer
    triangles: NDArray[np.uint32]  # (T, 3) uint32
    unit: float = 1.0  # metres a mesh unit
    mass: float = 0.0  # kilograms; 0: everything from the mesh
    # (3,); metres; meaningful with a mass
    center_of_mass: Array = field(default_factory=lambda: np.zeros(3))
    # (3, 3); kg m²; zeros: uniform
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))
    # restitution and drop height of the part's own scene; negative: the node's
    scene_override: tuple[float, float] = (-1.0, -1.0)
    stamp: int = 0  # nanoseconds; 0 where the sender gave none
    resource: str = ""  # a file that has the mesh, which is still to be read
    resource_unit: str = ""  # of that file; empty: what it names
    body: int = separation.BY_SHAPE  # as in the message

    @cached_property
    def content(self) -> bytes:
        """Digest of what makes the part, without its name and scene; 32 bytes."""
        digest = hashlib.sha256(f"{self.resource_unit}{self.resource}".encode())
        digest.update(np.ascontiguousarray(self.vertices).data)
        digest.update(np.ascontiguousarray(self.triangles).data)
        numbers = [self.unit, self.mass, *self.center_of_mass, *self.inertia.ravel()]
        numbers.append(self.body)
        digest.update(np.array(numbers, dtype="<f8").tobytes())
        return digest.digest()

    def bytes(self) -> int:
        """Size of the mesh."""
        return int(self.vertices.nbytes + self.triangles.nbytes)


def quote_text(text: str) -> str:
    """What a client sent, for a message or a log: quoted, in one short line."""
    return repr(text if len(text) <= MAX_QUOTED else text[:MAX_QUOTED] + "…")


def name_suffix(part_id: str) -> str:
    """A part in a line of the log; empty where it has no name yet."""
    return f", part {quote_text(part_id)}" if part_id else ""


def part_line(part: Part) -> str:
    """What has come: name, size, triangles."""
    size = " x ".join(f"{1e3 * x:.4g}" for x in np.ptp(part.surface_vertices, axis=0))
    return f"{part.part_id}: {size} mm, {len(part.triangles)} triangles"


def _has_nonzero(values: Array) -> bool:
    """Whether one is not 0; numpy would warn of some kinds of NaN."""
    return any(value != 0.0 for value in values.ravel().tolist())


def check_name(part_id: str) -> None:
    """Refuse names that would be cut or confuse a terminal; raises RequestError."""
    if len(part_id) > MAX_NAME or not part_id.isprintable():
        raise RequestError(
            f"a part_id of at most {MAX_NAME} printable characters",
            f"{len(part_id)} characters, {quote_text(part_id)}",
            "rename the part",
        )


def check_request(request: PartRequest, most_bytes: int) -> None:
    """Refuse what needs no look at every triangle; raises MeshError, RequestError."""
    check_name(request.part_id)
    if request.bytes() > most_bytes:
        raise MeshError(
            f"a mesh of at most {most_bytes} bytes (parameter max_mesh_bytes)",
            f"{request.bytes()} bytes, {len(request.triangles)} triangles",
            "decimate it, or raise the parameter",
        )
    if not (math.isfinite(request.unit) and request.unit > 0.0):
        raise RequestError(
            "a unit above 0, in metres a mesh unit",
            f"{request.unit}",
            "0.001 is a mesh in millimetres",
        )
    if request.mass == 0.0 and (
        _has_nonzero(request.inertia) or _has_nonzero(request.center_of_mass)
    ):
        raise RequestError(
            "a mass above 0 kg with a given centre of mass or inertia",
            "inertia.m = 0",
            "fill in inertia.m, or leave all of inertia zero",
        )


def build_part(request: PartRequest) -> Part:
    """Build the part; raises PoseStatsError with one line that says what is wrong."""
    has_mass = request.mass != 0.0
    # Broken messages have NaN of a kind that numpy warns of.
    with np.errstate(invalid="ignore"):
        return part_from_mesh(
            request.vertices,
            request.triangles,
            request.center_of_mass if has_mass else None,
            request.mass if has_mass else None,
            request.inertia if has_mass and _has_nonzero(request.inertia) else None,
            part_id=request.part_id,
            unit=request.unit,
            body=separation.choice_of_number(request.body),
        )


def estimator_name(method: str, restitution: float) -> str:
    """The estimator that a name stands for; RequestError if it stands for none."""
    if method == AUTO:
        return best_method(restitution)
    if method not in AT_ONCE:
        raise RequestError(
            f"a method that needs no drops, out of {', '.join(AT_ONCE)}",
            repr(method[:MAX_NAME]),
            "leave it empty for the node's; for drops ask for auto with a "
            "target_error, or start a drop simulation",
        )
    return method
