"""Families of bodies: random polyhedra, prisms, plates, ellipsoid hulls, machined parts."""

from .families import FAMILIES, family_part, family_tolerance

__all__ = ["FAMILIES", "family_part", "family_tolerance"]
