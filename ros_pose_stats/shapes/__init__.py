"""Shapes made by code: exact convex bodies here, modelled parts in other modules.

`modelling`, `demo_parts` and `random_parts` load the solid modeller manifold3d, so they are
imported only where such parts are made.
"""

from .closed_forms import (
    Surface,
    box,
    cylinder,
    dodecahedron,
    ellipsoid_points,
    hull_mesh,
    icosahedron,
    octahedron,
    prism,
    sphere_points,
    tetrahedron,
)

__all__ = [
    "Surface",
    "box",
    "cylinder",
    "dodecahedron",
    "ellipsoid_points",
    "hull_mesh",
    "icosahedron",
    "octahedron",
    "prism",
    "sphere_points",
    "tetrahedron",
]
