"""Families of bodies: random polyhedra, prisms, plates, hulls, machined and turned parts."""

from .curved import CURVED
from .families import FAMILIES, family_options, family_part, family_poses
from .rocking import ROCKING

__all__ = [
    "CURVED",
    "FAMILIES",
    "ROCKING",
    "family_options",
    "family_part",
    "family_poses",
]
