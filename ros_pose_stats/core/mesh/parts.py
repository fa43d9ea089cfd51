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

"""From a mesh to a part: arrays are checked, repaired, oriented and integrated."""

import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from ...base import errors, text
from ..records import Corners, Index, Mask, Part
from ..records.part import digest_name
from . import arrays, cad_shapes, files, mass_properties, units, winding
from .bodies import separation
from .hull import hull_of_part, keep_hull
from .surface import surface_of

_NO_ERROR = (
    " No error is told: the file promises a solid, and nobody knows what is lost of it."
)

_WIDEST_CRACK = 1.5e-3
"""Of a solid a hole is closed only where it is no wider than this fraction of its size,
which is how far from the true surface its mesh may be: faces that share no edge leave
such cracks. What is wider may be a face that was lost, and any shape."""


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
    body: separation.Choice = None,
    accept_open: bool = False,
) -> Part:
    """Load a part from a mesh file.

    Parameters
    ----------
    file : path
        STEP (with the package cascadio), STL, OBJ, PLY, OFF or 3MF.
    unit : str or float, optional
        `m`, `mm`, `cm`, `inch` or metres a mesh unit; default, or `auto`: what the file
        declares (STEP, 3MF), else metres up to a largest extent of 0.6 and millimetres
        beyond, with the warning `UNIT_GUESSED` and `unit_guessed` of the part.
    center_of_mass, mass, inertia, density
        See `part_from_mesh`.
    part_id : str
        Default: the file's name without its suffix; a `?` stands for what cannot be
        printed.
    unless_declared : bool
        Whether `unit` is for a file that declares none only, as where one is given for
        several files. Else it wins, with the warning `UNIT_OVERRIDDEN` where the file
        contradicts it.
    body : int or str, optional
        See `part_from_mesh`.
    accept_open : bool
        Whether to take the convex hull of a solid of a STEP file whose surface comes
        out with holes wider than a crack between faces. No answer about such a part
        tells an error: its shares and intervals of them are NaN, and what asks for one
        is refused. Else such a file is refused. Other files promise no solid; of them
        the hull is taken, with the warning `OPEN_MESH`.

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
        separation.check_choice(body),
        accept_open=accept_open,
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
    unit: str | float | None = None,
    body: separation.Choice = None,
    accept_open: bool = False,
) -> Part:
    """Make a part from a triangle mesh, or from the shape of a CAD system.

    Parameters
    ----------
    vertices : (V, 3) array, trimesh.Trimesh or shape
        In `unit`, part frame. A shape is what has `tessellate(tolerance)`, as those of
        FreeCAD, CadQuery and build123d; it is taken for a solid, like a STEP file.
    triangles : (T, 3) array of int
        Vertex numbers; either winding, repaired where it is inconsistent. None beside a
        Trimesh or a shape.
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
    unit : str or float, optional
        `m`, `mm`, `cm`, `inch` or metres a mesh unit. Default: millimetres of a shape,
        as CAD systems have them, and metres of all else.
    body : int or str, optional
        Which body of the mesh is the part, by falling volume of the hull from 0 on, or
        `all` for all as one rigid part. Bodies whose hulls come within 2 % of the
        radius of the whole count as one. Default: the mesh, if nothing in it stands
        apart; the first of equal ones.
    accept_open : bool
        Whether to take the convex hull of a shape whose surface comes out with holes;
        see `load_part`. Else it is refused. Of other meshes the hull is always taken.

    Returns
    -------
    Part
        With warnings `UNIT_SUSPECT`, `HOLES_CLOSED`, `OPEN_MESH`, `BODIES_OVERLAP` and
        `INERTIA_SUSPECT`, and notes `BODIES_APART` and `BODIES_LOOSE`, where they
        apply. Its mesh is that of the body alone.

    Raises
    ------
    MeshError
        If the arrays are no triangle mesh or span no volume, if a shape comes out open,
        or if bodies stand apart that differ, and `body` names none.
    MassPropertiesError
        If no rigid part of this shape can have the given mass properties, or if a
        density is given and the mesh encloses no volume that is known.
    RequestError
        If `unit` is not a unit, `part_id` no text, or `body` no body's number.
    """
    if not isinstance(part_id, str):
        raise errors.RequestError(
            "text for part_id", f"{part_id!r}", "leave it out for a name by digest"
        )
    properties = mass_properties.check_properties(
        center_of_mass, mass, inertia, density
    )
    mesh = _mesh_of(vertices, triangles)
    if unit is not None:
        mesh = mesh._replace(unit=units.metres_per_unit(unit))
    return part_of_file(
        mesh,
        properties,
        part_id,
        separation.check_choice(body),
        accept_open=accept_open,
    )


def _mesh_of(mesh: Any, triangles: ArrayLike | None) -> files.FileMesh:
    """Arrays, a Trimesh or a shape of CAD, in the unit that is usual for it."""
    if triangles is not None:
        return files.FileMesh(mesh, triangles, 1.0)
    # First, since shapes of CAD have methods that are called `faces` and `vertices`.
    if hasattr(mesh, "tessellate"):
        points, corners = cad_shapes.tessellate(mesh)
        return files.FileMesh(points, corners, cad_shapes.MILLIMETRE, of_solids=True)
    faces = getattr(mesh, "faces", None)
    if faces is None or callable(faces):
        raise errors.MeshError(
            "vertices and triangles, a trimesh.Trimesh, or a shape with tessellate",
            f"{type(mesh).__name__} alone",
            "give the triangles too; of a workplane of CadQuery give .val(), of a "
            "builder of build123d .part, of an object of FreeCAD .Shape",
        )
    return files.FileMesh(mesh.vertices, faces, 1.0)


def part_of_file(
    mesh: files.FileMesh,
    properties: mass_properties.GivenProperties,
    part_id: str,
    body: separation.Choice = None,
    *,
    accept_open: bool = False,
) -> Part:
    """Check, weld, close, orient and integrate the mesh of a file or of arrays."""
    metres, corners = arrays.check_mesh(mesh.vertices, mesh.triangles, mesh.unit)
    vertices, triangles = arrays.weld(metres, corners.astype(np.int64))
    chosen = separation.choose_body(vertices, triangles, body)
    if chosen is not None:
        mesh = _mesh_of_body(
            mesh, corners, chosen.in_body[cKDTree(vertices).query(metres)[1]]
        )
        metres, corners = arrays.check_mesh(mesh.vertices, mesh.triangles, mesh.unit)
        vertices, triangles = arrays.weld(metres, corners.astype(np.int64))
    rounding = arrays.coordinate_rounding(mesh.vertices, corners) * mesh.unit
    surface = surface_of(
        vertices, triangles, _WIDEST_CRACK if mesh.of_solids else math.inf
    )
    is_open_solid = mesh.of_solids and bool(surface.problem)
    if is_open_solid and not accept_open:
        raise _open_solid(triangles, surface.problem)
    kilograms, center, tensor = mass_properties.complete_properties(properties, surface)
    warnings = (
        *units.unit_warnings(
            surface.hull.scale, mesh.unit, mesh.unit_guessed, mesh.declared
        ),
        *(() if chosen is None else chosen.notes),
        *(
            warning._replace(text=warning.text + _NO_ERROR)
            if is_open_solid
            else warning
            for warning in surface.warnings
        ),
        *mass_properties.inertia_warning(tensor, kilograms, center, surface),
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
        unit=mesh.unit,
        unit_guessed=mesh.unit_guessed,
        bodies=1 if chosen is None else chosen.bodies,
        error_known=not is_open_solid,
    )
    keep_hull(part, surface.hull)
    return part


def _open_solid(triangles: Index, problem: str) -> errors.MeshError:
    """Refusal of a STEP file of whose solid some surface is lost."""
    open_edges = int((winding.group_edges(triangles).uses % 2).sum())
    return errors.MeshError(
        "a STEP file or a shape of a solid that is closed",
        f"one with {text.several(open_edges, 'open edge')}: its mesh {problem}",
        "export it again or heal it in CAD, or take its hull without an error, with "
        "--accept-open of estimate, simulate, report and animate (`accept_open` in the "
        "library)",
    )


def _mesh_of_body(
    mesh: files.FileMesh, corners: Corners, in_body: Mask
) -> files.FileMesh:
    """What a file would hold with no other body in it; `in_body` (V,): its vertices."""
    vertices, triangles = arrays.remove_unused(
        arrays.real_array(mesh.vertices), corners[in_body[corners[:, 0]]]
    )
    return mesh._replace(vertices=vertices, triangles=triangles)


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
    mass_properties.check_inside(center, part.surface_vertices, hull)
    name = "" if part.part_id == digest_name(part.digest) else part.part_id
    shifted = replace(part, part_id=name, center_of_mass=center)
    keep_hull(shifted, hull)
    return shifted
