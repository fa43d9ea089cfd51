"""Kinds of inputs of `part_from_mesh`, each input made from its seed alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple
from zlib import crc32

import numpy as np

from study.shapes import Surface

from . import arrays, masses, solids, surfaces
from .solids import Random

Fate = Literal["taken", "refused", "either"]


class Kind(NamedTuple):
    """How inputs are made, what must become of each, and what else is given with the mesh.

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
    "polyhedron": Kind(solids.polyhedron, "taken", same=True),
    "regular": Kind(solids.regular, "taken", same=True),
    "stretched": Kind(solids.stretched, same=True),
    "needle": Kind(solids.needle, same=True),
    "plate": Kind(solids.plate, same=True),
    "twin corners": Kind(solids.twins, "taken", same=True),
    "slivers": Kind(solids.slivers, "taken", same=True),
    "rough box": Kind(solids.rough_box, "taken", same=True),
    "lattice": Kind(solids.grid, "taken", same=True),
    "rings": Kind(solids.rings, same=True),
    "round": Kind(solids.round_body, "taken", same=True),
    "leaning": Kind(solids.leaning, "taken", same=True),
    "float32": Kind(solids.float32, same=True),
    "far away": Kind(solids.far),
    "units": Kind(solids.scaled, "taken", same=True),
    "wildest units": Kind(solids.scaled_widely),
    "repeated": Kind(surfaces.repeated, "taken", same=True),
    "subdivided": Kind(surfaces.fine, "taken", same=True),
    "turned round": Kind(surfaces.turned_round, "taken", same=True),
    "filled": Kind(surfaces.filled, "taken", same=True),
    "several bodies": Kind(surfaces.bodies, "taken", same=True),
    "stacked boxes": Kind(surfaces.stacked, "taken", same=True),
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
    "possible mass": Kind(solids.polyhedron, "taken", masses.possible),
    "nearly impossible mass": Kind(
        solids.polyhedron, "either", masses.nearly_impossible
    ),
    "impossible mass": Kind(solids.polyhedron, "refused", masses.impossible),
    "any mass": Kind(solids.polyhedron, "either", masses.any_numbers),
    "any option": Kind(solids.polyhedron, "either", masses.any_option),
}


def case(kind: str, seed: int) -> tuple[Any, Any, dict[str, Any]]:
    """Vertices, triangles and options of the input with a seed; the same in every process."""
    random = np.random.default_rng([crc32(kind.encode()), seed])
    chosen = KINDS[kind]
    vertices, triangles = chosen.make(random)
    options = (
        {} if chosen.options is None else chosen.options(random, (vertices, triangles))
    )
    return vertices, triangles, options
