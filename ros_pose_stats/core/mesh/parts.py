"""From a mesh to a part: arrays are checked, repaired, oriented and integrated."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base import errors, text
from .. import tolerances
from ..kernels.principal_axes import principal_axes
from ..records import Array, Part
from ..records.part import digest_name
from . import arrays, files, mass_properties, units, vectors
from .hull import Hull, hull_of_part, keep_hull
from .surface import Surface, distance_to_hull, surface_of

LEAST_SHARE = 1e-7
MOST_SHARE = 1e10
"""Of mass times squared radius, which a largest moment may have: g mm² are 1e9 too
many."""


def load_part(
    file: str | os.PathLike[str],
    unit: str | float | None = None,
    center_of_mass: ArrayLike | None = None,
    mass: float | None = None,
    inertia: ArrayLike | None = None,
    *,
    density: float | None = None,
    part_id: str = "",
    unless_declared: bool = False,
) -> Part:
    """Load a part from a mesh file.

    Parameters
    ----------
    file : path
        STEP (with the package cascadio), STL, OBJ, PLY, OFF or 3MF.
    unit : str or float, optional
        `m`, `mm`, `cm`, `inch` or metres a mesh unit; default: what the file declares
        (STEP, 3MF), else metres. `auto`: what the file declares, else a guess, with a
        warning.
    center_of_mass, mass, inertia, density
        See `part_from_mesh`.
    part_id : str
        Default: the file's name without its suffix; a `?` stands for what cannot be
        printed.
    unless_declared : bool
        Whether `unit` is for a file that declares none only, as where one is given for
        several files. Else it wins, with the warning `UNIT_OVERRIDDEN` where the file
        contradicts it.

    Returns
    -------
    Part

    Raises
    ------
    MeshFileError, MeshError, MassPropertiesError, RequestError
        Each with one line that says what is wrong.
    """
    mesh = files.read_mesh(file, unit, unless_declared=unless_declared)
    return part_of_file(
        mesh,
        mass_properties.check_properties(center_of_mass, mass, inertia, density),
        part_id or text.printable(Path(file).stem),
    )


def part_from_mesh(
    vertices: ArrayLike | Any,
    triangles: ArrayLike | None = None,
    center_of_mass: ArrayLike | None = None,
    mass: float | None = None,
    inertia: ArrayLike | None = None,
    *,
    density: float | None = None,
    part_id: str = "",
    unit: str | float = 1.0,
) -> Part:
    """Make a part from a triangle mesh.

    Parameters
    ----------
    vertices : (V, 3) array or trimesh.Trimesh
        In `unit`, part frame.
    triangles : (T, 3) array of int
        Vertex numbers; either winding, repaired where it is inconsistent. None beside a
        Trimesh.
    center_of_mass : (3,) array, optional
        Metres, part frame, strictly inside the convex hull; default: uniform density.
        Given alone, the uniform body's inertia about its own centroid is kept.
    mass : float, optional
        Kilograms; default 1.
    inertia : (3, 3) array, optional
        About the centre of mass in part axes, kg m²; needs `mass` or `density`.
        Default, or zeros: uniform density.
    density : float, optional
        kg/m³, in place of `mass`: the mass is that of the enclosed volume.
    part_id : str
        Default: `mesh_` and twelve digits of the digest.
    unit : str or float
        `m`, `mm`, `cm`, `inch` or metres a mesh unit.

    Returns
    -------
    Part
        With warnings `UNIT_SUSPECT`, `HOLES_CLOSED`, `OPEN_MESH`, `BODIES_OVERLAP` and
        `INERTIA_SUSPECT` where they apply.

    Raises
    ------
    MeshError
        If the arrays are no triangle mesh or span no volume.
    MassPropertiesError
        If no rigid part of this shape can have the given mass properties, or if a
        density is given and the mesh encloses no volume that is known.
    RequestError
        If `unit` is not a unit, or `part_id` no text.
    """
    if not isinstance(part_id, str):
        raise errors.RequestError(
            "text for part_id", f"{part_id!r}", "leave it out for a name by digest"
        )
    if triangles is None:
        mesh: Any = vertices
        if not hasattr(mesh, "faces"):
            raise errors.MeshError(
                "vertices and triangles, or a trimesh.Trimesh",
                f"{type(mesh).__name__} alone",
                "give the triangles too",
            )
        vertices = mesh.vertices
        triangles = mesh.faces
    properties = mass_properties.check_properties(
        center_of_mass, mass, inertia, density
    )
    return part_of_file(
        files.FileMesh(vertices, triangles, units.metres_per_unit(unit)),
        properties,
        part_id,
    )


def part_of_file(
    mesh: files.FileMesh, properties: mass_properties.GivenProperties, part_id: str
) -> Part:
    """Check, weld, close, orient and integrate the mesh of a file or of arrays."""
    metres, corners = arrays.check_mesh(mesh.vertices, mesh.triangles, mesh.unit)
    surface = surface_of(metres, corners.astype(np.int64))
    rounding = arrays.coordinate_rounding(mesh.vertices, corners) * mesh.unit
    kilograms, center, tensor = _mass_properties(properties, surface)
    warnings = (
        *units.unit_warnings(
            surface.hull.scale,
            metres,
            corners,
            mesh.unit,
            mesh.unit_source,
            mesh.declared,
        ),
        *surface.warnings,
        *_inertia_warning(tensor, kilograms, center, surface),
    )
    part = Part(
        part_id,
        metres,
        corners,
        surface.vertices,
        surface.triangles,
        kilograms,
        center,
        tensor,
        warnings,
        rounding,
        notes=surface.notes,
    )
    keep_hull(part, surface.hull)
    return part


def _mass_properties(
    properties: mass_properties.GivenProperties, surface: Surface
) -> tuple[float, Array, Array]:
    """Mass, centre of mass and inertia: given ones, else those of the solid."""
    center = surface.solid.centroid
    kilograms = 1.0 if properties.mass is None else properties.mass
    if properties.density is not None:
        if surface.from_hull:
            raise errors.MassPropertiesError(
                "a closed mesh where a density is given",
                "one whose volume is not known, as it is open",
                "give the mass instead, or export the mesh closed",
            )
        kilograms = mass_properties.check_mass(
            properties.density * surface.solid.volume
        )
    if properties.center_of_mass is not None:
        _check_inside(properties.center_of_mass, surface.vertices, surface.hull)
        center = properties.center_of_mass
    uniform = surface.solid.inertia * (kilograms / surface.solid.volume)
    return (
        kilograms,
        center,
        uniform if properties.inertia is None else properties.inertia,
    )


def shift_center(part: Part, offset: ArrayLike) -> Part:
    """The same part with its centre of mass elsewhere, as a filling moves it.

    Mesh, mass, and the inertia about the centre of mass stay, and so does the convex
    hull, which is not computed again.

    Parameters
    ----------
    part : Part
    offset : (3,) array_like
        From the old centre of mass to the new one, metres, part frame.

    Returns
    -------
    Part
        With a digest of its own; `part` itself where the offset is zero.

    Raises
    ------
    MassPropertiesError
        If the offset is not three finite numbers, or leads out of the convex hull.
    """
    step = mass_properties.check_offset(offset)
    if not step.any():
        return part
    center = part.center_of_mass + step
    hull = hull_of_part(part)
    _check_inside(center, part.surface_vertices, hull)
    name = "" if part.part_id == digest_name(part.digest) else part.part_id
    shifted = replace(part, part_id=name, center_of_mass=center)
    keep_hull(shifted, hull)
    return shifted


def _check_inside(center: Array, vertices: Array, hull: Hull) -> None:
    """Refuse a centre of mass on or outside the convex hull."""
    distance = distance_to_hull(center, hull)
    # The square of a distance from far outside may be beyond float64.
    radius = hull.scale if distance > hull.scale else _reach(center, vertices)
    if distance < -tolerances.ON_HULL * radius:
        return
    on_hull = distance <= tolerances.ON_HULL * radius
    position = (
        "on its surface" if on_hull else f"{text.length_in_words(distance)} outside"
    )
    raise errors.MassPropertiesError(
        "a centre of mass inside the part's convex hull",
        "({:.6g}, {:.6g}, {:.6g}) mm, ".format(*1e3 * center) + position,
        "check its unit, and that it is in the mesh's own frame",
    )


def _reach(center: Array, vertices: Array) -> float:
    """Largest distance of a vertex from the centre of mass, metres."""
    return float(vectors.lengths(vertices - center).max())


def _inertia_warning(
    inertia: Array, mass: float, center: Array, surface: Surface
) -> tuple[str, ...]:
    """Warn about an inertia that no material inside can have; refuse absurd ones."""
    reach = _reach(center, surface.vertices)
    limit = mass * reach * reach
    moment = float(principal_axes(inertia)[0][-1])
    if not LEAST_SHARE * limit <= moment <= MOST_SHARE * limit:
        raise errors.MassPropertiesError(
            f"moments of inertia from {LEAST_SHARE * limit:.3g} to "
            f"{MOST_SHARE * limit:.3g} kg m² of a part of this size and mass",
            f"{moment:.3g} kg m²",
            "check the unit of the tensor",
        )
    if moment <= limit * (1.0 + tolerances.TRIANGLE_INEQUALITY):
        return ()
    return (
        f"INERTIA_SUSPECT: a principal moment of {moment:.3g} kg m² is more than "
        f"material inside the part can have ({limit:.3g} kg m²); check its unit (kg "
        "mm², g mm²).",
    )
