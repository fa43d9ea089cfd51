"""Volume, centroid and inertia of a solid, and checks of given mass properties.

A closed surface is split into tetrahedra from one common apex; their signed volumes,
first and second moments are polynomials in the vertices and add up exactly (divergence
theorem). The apex is the centre of the bounding box and the size is scaled to one, so
neither the place of the part nor its unit costs digits. Powers are written as
products, for the C library's round differently on other processors.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...base.errors import MassPropertiesError
from ..kernels.mesh.measures import solid_moments
from ..kernels.principal_axes import principal_axes
from ..records import Array, Index
from ..tolerances import TRIANGLE_INEQUALITY
from .arrays import NOT_NUMBERS, real_array, real_number
from .vectors import to_unit_size

# Beyond it products with squares of lengths from 1e-50 to 1e50 m come near the ends of
# float64.
_SMALLEST_MASS = 1e-100

# Foam and the densest metals; what is beyond was meant in g/cm³.
_LIGHTEST = 20.0
_HEAVIEST = 25_000.0


class Solid(NamedTuple):
    """A solid of density one."""

    volume: float  # m³; negative when the surface is wound inward
    centroid: Array  # (3,); metres; NaN when the volume is zero
    inertia: Array  # (3, 3); about the centroid, m⁵ (times a density: kg m²)


def solid_of(vertices: Array, triangles: Index) -> Solid:
    """Integrate over the solid that a closed surface encloses."""
    points, shift, scale = to_unit_size(vertices)
    volume, *moments = solid_moments(points, np.ascontiguousarray(triangles)).tolist()
    if volume == 0.0:
        return Solid(0.0, np.full(3, math.nan), np.full((3, 3), math.nan))
    x, y, z = (moment / volume for moment in moments[:3])
    xx, yy, zz, xy, xz, yz = moments[3:]
    xx = xx - volume * x * x
    yy = yy - volume * y * y
    zz = zz - volume * z * z
    xy = xy - volume * x * y
    xz = xz - volume * x * z
    yz = yz - volume * y * z
    inertia = np.array([[yy + zz, -xy, -xz], [-xy, xx + zz, -yz], [-xz, -yz, xx + yy]])
    cube = scale * scale * scale
    return Solid(
        volume * cube,
        shift + scale * np.array([x, y, z]),
        inertia * (cube * scale * scale),
    )


class GivenProperties(NamedTuple):
    """Given mass properties after their check.

    None for those that follow from the mesh.
    """

    mass: float | None  # kilograms
    center_of_mass: Array | None  # (3,); metres, part frame
    inertia: Array | None  # (3, 3); about the centre of mass in part axes, kg m²
    density: float | None = None  # kg/m³, in place of the mass


def check_properties(
    center_of_mass: ArrayLike | None,
    mass: float | None,
    inertia: ArrayLike | None,
    density: float | None = None,
) -> GivenProperties:
    """Check given properties without the mesh.

    An inertia of zeros stands for the uniform one.
    """
    if mass is not None and density is not None:
        raise MassPropertiesError(
            "a mass or a density", "both", "leave one of them out"
        )
    kilograms = None if mass is None else check_mass(mass)
    density_value = None if density is None else _check_density(density)
    tensor = (
        None if inertia is None else _check_inertia(inertia, kilograms or density_value)
    )
    center = None
    if center_of_mass is not None:
        center = _numbers(
            center_of_mass,
            (3,),
            "a centre of mass of three finite numbers in metres",
            "leave it out for uniform density",
        )
    return GivenProperties(kilograms, center, tensor, density_value)


def _number(number: float, expected: str) -> float:
    try:
        return real_number(number)
    except NOT_NUMBERS as error:
        raise MassPropertiesError(expected, f"{number!r}", "give one number") from error


def _check_density(density: float) -> float:
    value = _number(density, "a density in kg/m³")
    if not _LIGHTEST <= value <= _HEAVIEST:
        raise MassPropertiesError(
            f"a density from {_LIGHTEST:g} to {_HEAVIEST:g} kg/m³",
            f"{value:g} kg/m³",
            "1 g/cm³ is 1000 kg/m³, and steel has 7850",
        )
    return value


def check_mass(mass: float) -> float:
    """A mass that can be computed with, as a float."""
    value = _number(mass, "a mass in kilograms")
    if not 0.0 < value < math.inf:
        raise MassPropertiesError(
            "a finite mass above 0 kg", f"{value} kg", "leave it out for unit mass"
        )
    if not _SMALLEST_MASS <= value <= 1.0 / _SMALLEST_MASS:
        raise MassPropertiesError(
            f"a mass from {_SMALLEST_MASS:g} to {1.0 / _SMALLEST_MASS:g} kg",
            f"{value:g} kg",
            "check its unit",
        )
    return value


def check_offset(offset: ArrayLike) -> Array:
    """Check by how much (3,) a centre of mass is to be shifted."""
    return _numbers(
        offset,
        (3,),
        "a shift of the centre of mass of three finite numbers in metres",
        "0, 0, 0 leaves it where it is",
    )


def _check_inertia(inertia: ArrayLike, mass: float | None) -> Array | None:
    tensor = _numbers(
        inertia,
        (3, 3),
        "an inertia tensor of 3 x 3 finite numbers in kg m²",
        "leave it out for uniform density",
    )
    if mass is None:
        raise MassPropertiesError(
            "a mass with the inertia tensor",
            "a tensor alone",
            "give the mass in kilograms too",
        )
    if not tensor.any():
        return None
    _check_physical(tensor)
    return 0.5 * tensor + 0.5 * tensor.T


def _numbers(
    values: ArrayLike, shape: tuple[int, ...], expected: str, remedy: str
) -> Array:
    """Copy finite numbers of a shape as float64."""
    try:
        array = real_array(values).copy()
    except NOT_NUMBERS as error:
        raise MassPropertiesError(
            expected, f"{values!r}", "give plain numbers"
        ) from error
    if array.shape != shape or not np.isfinite(array).all():
        raise MassPropertiesError(expected, f"{array.tolist()}", remedy)
    return array


def _check_physical(tensor: Array) -> None:
    """Refuse a tensor that is not symmetric or positive, or of no mass distribution."""
    size = np.abs(tensor).max()
    scaled = tensor / size
    asymmetry = np.abs(scaled - scaled.T).max()
    if asymmetry > TRIANGLE_INEQUALITY:
        raise MassPropertiesError(
            "a symmetric inertia tensor",
            f"opposite entries that differ by {asymmetry:.2g} of the largest",
            "products of inertia appear twice with the same sign",
        )
    moments, _ = principal_axes(0.5 * (scaled + scaled.T))
    # A needle of 1 : 1e-7 has moments of 1 : 1e-14; eigenvalues are good to 1e-16.
    if moments[0] <= 1e-15 * moments[2]:
        raise MassPropertiesError(
            "positive principal moments of inertia",
            f"{(moments * size).tolist()} kg m²",
            "check signs and units of the tensor",
        )
    if moments[0] + moments[1] < moments[2] * (1.0 - TRIANGLE_INEQUALITY):
        raise MassPropertiesError(
            "principal moments of inertia of which no one exceeds the sum of the "
            "others",
            f"{(moments * size).tolist()} kg m²",
            "products of inertia may have the opposite sign in your CAD system",
        )
