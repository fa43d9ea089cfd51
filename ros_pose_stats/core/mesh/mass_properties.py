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

"""Given mass properties: checked, and completed by those of the solid."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...base import text
from ...base.errors import MassPropertiesError
from ..kernels.principal_axes import principal_axes
from ..records import Array
from ..records.notes import Note, note
from ..tolerances import ON_HULL, TRIANGLE_INEQUALITY
from .arrays import NOT_NUMBERS, real_array, real_number
from .hull import Hull, distance_to_hull
from .surface import Surface
from .vectors import lengths

# Beyond it products with squares of lengths from 1e-50 to 1e50 m come near the ends of
# float64.
_SMALLEST_MASS = 1e-100

# Foam and the densest metals; what is beyond was meant in g/cm³.
_LIGHTEST = 20.0
_HEAVIEST = 25_000.0


LEAST_SHARE = 1e-7
MOST_SHARE = 1e10
"""Of mass times squared radius, which a largest moment may have: g mm² are 1e9 too
many."""


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
    density: float | None,
) -> GivenProperties:
    """Check given properties without the mesh.

    An inertia of zeros stands for the uniform one.
    """
    if mass is not None and density is not None:
        raise MassPropertiesError(
            "a mass or a density", "both", "leave one of them out"
        )
    kilograms = None if mass is None else _check_mass(mass)
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


def _check_mass(mass: float) -> float:
    """A mass that can be computed with, as a float."""
    return _check_range(_number(mass, "a mass in kilograms"))


def _check_range(value: float) -> float:
    """Refuse a mass, in kilograms, that cannot be computed with."""
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
    # As numbers of Python, which become infinite without a warning.
    shown_moments = [moment * float(size) for moment in moments.tolist()]
    # A needle of 1 : 1e-7 has moments of 1 : 1e-14; eigenvalues are good to 1e-16.
    if moments[0] <= 1e-15 * moments[2]:
        raise MassPropertiesError(
            "positive principal moments of inertia",
            f"{shown_moments} kg m²",
            "check signs and units of the tensor",
        )
    if moments[0] + moments[1] < moments[2] * (1.0 - TRIANGLE_INEQUALITY):
        raise MassPropertiesError(
            "principal moments of inertia of which no one exceeds the sum of the "
            "others",
            f"{shown_moments} kg m²",
            "products of inertia may have the opposite sign in your CAD system",
        )


def complete_properties(
    properties: GivenProperties, surface: Surface
) -> tuple[float, Array, Array]:
    """Mass, centre of mass and inertia: given ones, else those of the solid."""
    center = surface.solid.centroid
    kilograms = 1.0 if properties.mass is None else properties.mass
    if properties.density is not None:
        if surface.problem:
            raise MassPropertiesError(
                "a closed mesh where a density is given",
                "one whose volume is not known, as it is open",
                "give the mass instead, or export the mesh closed",
            )
        kilograms = _check_range(properties.density * surface.solid.volume)
    if properties.center_of_mass is not None:
        check_inside(properties.center_of_mass, surface.vertices, surface.hull)
        center = properties.center_of_mass
    uniform = surface.solid.inertia * (kilograms / surface.solid.volume)
    return (
        kilograms,
        center,
        uniform if properties.inertia is None else properties.inertia,
    )


def check_inside(center: Array, vertices: Array, hull: Hull) -> None:
    """Refuse a centre of mass on or outside the convex hull."""
    distance = distance_to_hull(center, hull)
    # The square of a distance from far outside may be beyond float64.
    radius = hull.scale if distance > hull.scale else _reach(center, vertices)
    if distance < -ON_HULL * radius:
        return
    on_hull = distance <= ON_HULL * radius
    position = (
        "on its surface" if on_hull else f"{text.length_in_words(distance)} outside"
    )
    raise MassPropertiesError(
        "a centre of mass inside the part's convex hull",
        "({:.6g}, {:.6g}, {:.6g}) mm, ".format(*(1e3 * x for x in center.tolist()))
        + position,
        "check its unit, and that it is in the mesh's own frame",
    )


def _reach(center: Array, vertices: Array) -> float:
    """Largest distance of a vertex from the centre of mass, metres."""
    return float(lengths(vertices - center).max())


def inertia_warning(
    inertia: Array, mass: float, center: Array, surface: Surface
) -> tuple[Note, ...]:
    """Warn about an inertia that no material inside can have; refuse absurd ones."""
    reach = _reach(center, surface.vertices)
    limit = mass * reach * reach
    moment = float(principal_axes(inertia)[0][-1])
    if not LEAST_SHARE * limit <= moment <= MOST_SHARE * limit:
        raise MassPropertiesError(
            f"moments of inertia from {LEAST_SHARE * limit:.3g} to "
            f"{MOST_SHARE * limit:.3g} kg m² of a part of this size and mass",
            f"{moment:.3g} kg m²",
            "check the unit of the tensor",
        )
    if moment <= limit * (1.0 + TRIANGLE_INEQUALITY):
        return ()
    return (
        note(
            "INERTIA_SUSPECT",
            f"a principal moment of {moment:.3g} kg m² is more than material inside "
            f"the part can have ({limit:.3g} kg m²); check its unit (kg mm², g mm²).",
        ),
    )
