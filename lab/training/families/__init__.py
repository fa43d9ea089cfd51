"""Families of bodies: random polyhedra, prisms, plates, hulls, machined and turned parts."""

from .families import FAMILIES, family_options, family_part, family_poses

__all__ = ["FAMILIES", "family_options", "family_part", "family_poses"]
