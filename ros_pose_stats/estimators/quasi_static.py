"""Quasi-static estimators: the part topples face by face until one is stable (4.B, 4.C)."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..kernels.body.equilibria import settle_on_stable
from ..resting.convex_body import ConvexBody
from ..resting.equilibria import Equilibria
from ..resting.poses import RestingPoses
from .solid_angles import Array, normalized

NQSE_COEFFICIENTS: Final = (-0.874, 8.03, -16.3, 7.70)
"""c0 … c3 of Eq. 6 as published (section 4.C)."""

PQSE_SHARE: Final = 0.555
"""Redistributed share of PQSE in this project's reading, fitted to Budden's measured dice by
`training/fit_pqse.py`."""


def qse(resting: RestingPoses) -> Array:
    """Quasi-static estimator [26], section 4.B.

    Every face starts with its centroid solid angle over 4 pi. An unstable face topples over
    the side pierced by the segment from its centroid to the foot of the centre of mass, and
    hands its probability to the neighbour there (half to each of two where the segment
    leaves through a corner).
    """
    return normalized(resting.gather(_toppled_shares(resting.equilibria)))


def nqse(resting: RestingPoses) -> Array:
    """Nonlinear quasi-static estimator, Eq. 6 with the published coefficients.

    Probabilities proportional to f(e_j), e_j the quasi-static estimate of pose j. For a
    cluster e_j is the sum over its members: taken facet by facet, f would give a tessellated
    curve the less the finer it is.
    """
    return normalized(nonlinear(qse(resting)))


def pqse(resting: RestingPoses) -> Array:
    """Perturbed quasi-static estimator [25], in this project's reading.

    The paper does not give the redistribution rule of [25]. In our reading the side between
    faces i and j moves by an angle proportional to the difference of the tilts at which the
    part topples over it from either face, and the strip that it sweeps changes hands. Face i
    takes `share * arc / (4 pi) * (tilt_i - tilt_j)` from face j, where arc is the angle that
    the side spans seen from the centre of mass. A face that would give more than it has
    gives all it has, in proportion (the paper's remedy against negative probabilities).
    The result then topples as in the quasi-static estimator, to which a share of 0 leads back.
    """
    return perturbed_quasi_static(resting, PQSE_SHARE)


def perturbed_quasi_static(resting: RestingPoses, share: float) -> Array:
    """The estimate of `pqse` for any redistributed share, `share` >= 0, without unit."""
    found = resting.equilibria
    start = _redistribute(found, share)
    arrays = found.arrays
    settled = settle_on_stable(start, arrays.target, arrays.share)
    return normalized(resting.gather(settled[found.faces]))


def nonlinear(share: Array) -> Array:
    """The function f of Eq. 6, never below 0; its argument is a probability."""
    c0, c1, c2, c3 = NQSE_COEFFICIENTS
    bend = c0 + share * (c1 + share * (c2 + share * c3))
    return np.maximum(share + share * (1.0 - share) * bend, 0.0)


def _toppled_shares(found: Equilibria) -> Array:
    """Share (S,) of each stable face after all toppling, by rising height."""
    return found.arrays.toppled[found.faces]


def _redistribute(found: Equilibria, share: float) -> Array:
    body = found.body
    arrays = body.arrays
    start = arrays.angle / arrays.angle.sum()
    taker, giver = arrays.face, arrays.face[arrays.twin]
    flow = share * _arcs(body) / (4.0 * np.pi) * (found.tilts - found.tilts[arrays.twin])
    flow = np.maximum(flow, 0.0)
    outflow = np.bincount(giver, flow, body.faces)
    with np.errstate(divide="ignore", invalid="ignore"):
        limit = np.where(outflow > start, start / outflow, 1.0)
    flow *= limit[giver]
    change = np.bincount(taker, flow, body.faces) - np.bincount(giver, flow, body.faces)
    return np.asarray(np.maximum(start + change, 0.0))


def _arcs(body: ConvexBody) -> Array:
    """Angle (N,) that each polygon side spans seen from the centre of mass."""
    arrays = body.arrays
    return np.asarray(np.arctan2(arrays.start, arrays.reach)
                      + np.arctan2(arrays.stop, arrays.reach))
