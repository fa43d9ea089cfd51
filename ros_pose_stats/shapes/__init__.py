"""Shapes made by code: exact convex bodies here, the demo parts in `demo_parts`.

`demo_parts` loads the solid modeller manifold3d, so it is imported only where the demo parts
are made.
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
