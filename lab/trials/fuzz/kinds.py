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

"""Kinds of inputs of `part_from_mesh`, each input made from its seed alone."""

from collections.abc import Callable
from typing import Any, Literal, NamedTuple
from zlib import crc32

import numpy as np

from lab.bodies import degenerate
from lab.bodies.degenerate import Random
from lab.bodies.shapes import Surface

from . import arrays, masses, surfaces

Fate = Literal["taken", "refused", "either"]


class Kind(NamedTuple):
    """How inputs are made, what must become of each, and what else is given with the
    mesh.

    `same`: the body is the same to rounding when it is given differently.
    """

    make: Callable[[Random], tuple[Any, Any]]
    fate: Fate = "either"
    options: Callable[[Random, Surface], dict[str, Any]] | None = None
    same: bool = False

    @property
    def done(self) -> str:
        """What is tried, in a sentence."""
        return (
            ((self.options or self.make).__doc__ or "").partition("\n")[0].rstrip(".")
        )


KINDS: dict[str, Kind] = {
    "polyhedron": Kind(degenerate.polyhedron, "taken", same=True),
    "regular": Kind(degenerate.regular, "taken", same=True),
    "stretched": Kind(degenerate.stretched, same=True),
    "needle": Kind(degenerate.needle, same=True),
    "plate": Kind(degenerate.plate, same=True),
    "twin corners": Kind(degenerate.twins, "taken", same=True),
    "slivers": Kind(degenerate.slivers, "taken", same=True),
    "rough box": Kind(degenerate.rough_box, "taken", same=True),
    "lattice": Kind(degenerate.grid, "taken", same=True),
    "rings": Kind(degenerate.rings, same=True),
    "round": Kind(degenerate.round_body, "taken", same=True),
    "leaning": Kind(degenerate.leaning, "taken", same=True),
    "float32": Kind(degenerate.float32, same=True),
    "far away": Kind(degenerate.far),
    "units": Kind(degenerate.scaled, "taken", same=True),
    "wildest units": Kind(degenerate.scaled_widely),
    "repeated": Kind(surfaces.repeated, "taken", same=True),
    "subdivided": Kind(surfaces.fine, "taken", same=True),
    "turned round": Kind(surfaces.turned_round, "taken", same=True),
    "filled": Kind(surfaces.filled, "taken", same=True),
    "several bodies": Kind(surfaces.bodies, "taken", masses.one_rigid_part, same=True),
    "stacked boxes": Kind(surfaces.stacked, "taken", masses.one_rigid_part, same=True),
    "soup": Kind(surfaces.soup, same=True),
    "tangle": Kind(surfaces.tangle, same=True),
    "lattice tangle": Kind(surfaces.lattice_tangle),
    "crowded edges": Kind(surfaces.crowded_edges, "taken"),
    "torn": Kind(surfaces.torn),
    "torus, Klein bottle": Kind(surfaces.ring_body, "taken", same=True),
    "dented": Kind(surfaces.dented),
    "bad values": Kind(arrays.bad_values, "refused"),
    "tiny values": Kind(arrays.tiny_values),
    "bad indices": Kind(arrays.bad_indices),
    "bad shapes": Kind(arrays.bad_shapes, "refused"),
    "other types": Kind(arrays.good_types, "taken"),
    "few bits": Kind(arrays.small_numbers),
    "any numbers": Kind(arrays.any_numbers),
    "any objects": Kind(arrays.any_objects),
    "possible mass": Kind(degenerate.polyhedron, "taken", masses.possible),
    "nearly impossible mass": Kind(
        degenerate.polyhedron, "either", masses.nearly_impossible
    ),
    "impossible mass": Kind(degenerate.polyhedron, "refused", masses.impossible),
    "any mass": Kind(degenerate.polyhedron, "either", masses.any_numbers),
    "any option": Kind(degenerate.polyhedron, "either", masses.any_option),
}


def case(kind: str, seed: int) -> tuple[Any, Any, dict[str, Any]]:
    """Vertices, triangles and options of the input with a seed; the same in every
    process.
    """
    random = np.random.default_rng([crc32(kind.encode()), seed])
    chosen = KINDS[kind]
    vertices, triangles = chosen.make(random)
    options = (
        {} if chosen.options is None else chosen.options(random, (vertices, triangles))
    )
    return vertices, triangles, options
