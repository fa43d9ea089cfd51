"""Steps that a suggestion may combine: changes that leave the part as symmetric as it is."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..errors import RequestError
from ..resting.convex_body import convex_body
from .alike import feature_images, first_of_orbits
from .changes import ChangedPart, DesignSpace
from .features import EDGE

Array = NDArray[np.float64]

NOTHING: Final = 1e-6
"""Share of an axis that symmetry leaves, below which it leaves none."""


def tied_steps(space: DesignSpace, within: float) -> Array:
    """Steps (t, n) of the features, each as far as the outline or the centre of mass may move.

    Faces and edges that a rotation of the part carries into each other are changed together. The
    centre of mass moves, and the part is stretched, only along what all rotations leave.
    """
    rotations, images = feature_images(space)
    count = len(space.features)
    corners = space.body.points[np.unique(space.body.arrays.corner)]
    reach = np.abs(corners).max(axis=0) * space.body.radius
    steps = []
    centres = rotations.mean(axis=0).T
    # R E_i R^T has the squares of the i-th column of R on its diagonal.
    stretches = (rotations ** 2).mean(axis=0).T
    for along in _distinct(centres):
        steps.append(np.append(within * along / np.linalg.norm(along), np.zeros(count - 3)))
    for along in _distinct(stretches):
        if _keeps_stretch(rotations, along):
            step = np.zeros(count)
            step[3:6] = within * along / (reach * along).max()
            steps.append(step)
    orbit = first_of_orbits(images)
    for first in np.unique(orbit[6:]).tolist():
        steps.append(np.where(orbit == first, within, 0.0))
    return np.array(steps)


def is_forward(space: DesignSpace, steps: Array) -> NDArray[np.bool_]:
    """Which of some steps (t, n) go one way only."""
    return np.asarray((steps[:, space.kinds == EDGE] > 0.0).any(axis=1))


def outline_move(space: DesignSpace, changed: ChangedPart) -> float:
    """How far the outline has moved, metres, measured across the faces before and after."""
    before, after = space.body, convex_body(changed.part, space.round_sides)
    shift = changed.part.center_of_mass - space.part.center_of_mass
    old, new = before.points * before.radius, after.points * after.radius + shift
    beyond = (new @ before.arrays.normal.T - before.arrays.distance * before.radius).max()
    left = ((old - shift) @ after.arrays.normal.T - after.arrays.distance * after.radius).max()
    return float(max(beyond, left, 0.0))


def center_move(space: DesignSpace, changed: ChangedPart) -> float:
    """How far the centre of mass has moved, metres, be it by itself or with the outline."""
    return float(np.linalg.norm(changed.part.center_of_mass - space.part.center_of_mass))


def check_within(within: float, radius: float) -> None:
    """Refuse a bound that is none.

    Raises RequestError if it is not above 0 and at most half the radius.
    """
    if not 0.0 < within <= 0.5 * radius:
        raise RequestError(f"a bound above 0 and at most {500.0 * radius:.3g} mm, half the "
                           "part's radius", f"{1e3 * within:.3g} mm",
                           "give how far the outline may move, in millimetres")


def _distinct(rows: Array) -> list[Array]:
    """Rows that are not nearly zero, and no multiples of those before."""
    found: list[Array] = []
    for row in rows:
        length = float(np.linalg.norm(row))
        if length > NOTHING and all(
                np.linalg.norm(np.cross(row, other)) > NOTHING * length for other in found):
            found.append(row)
    return found


def _keeps_stretch(rotations: Array, along: Array) -> bool:
    """Whether all rotations leave a stretch along the axes as it is."""
    tensor = np.diag(along)
    return bool(np.abs(rotations @ tensor @ rotations.transpose(0, 2, 1) - tensor).max()
                < 10.0 * NOTHING)
