"""Small vector helpers that are inlined into the kernels."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .compilation import inlined, kernel

Array = NDArray[np.float64]


@kernel
def dot(a: Array, b: Array) -> float:
    """Scalar product of two 3-vectors."""
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@kernel
def norm(a: Array) -> float:
    """Length of a 3-vector."""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@kernel
def inverse_of(matrix: Array) -> Array:
    """Inverse (3, 3) of a regular matrix (3, 3), by cofactors."""
    cofactors = np.empty((3, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for c in range(3):
            d, e = (c + 1) % 3, (c + 2) % 3
            cofactors[c, i] = matrix[j, d] * matrix[k, e] - matrix[j, e] * matrix[k, d]
    determinant = (matrix[0, 0] * cofactors[0, 0] + matrix[0, 1] * cofactors[1, 0]
                   + matrix[0, 2] * cofactors[2, 0])
    cofactors /= determinant
    return cofactors


@inlined
def length_of(x: float, y: float, z: float) -> float:
    """Length of a vector by its components.

    Written as products, for Python's power rounds by the C library where it runs kernels itself.
    """
    return math.sqrt(x * x + y * y + z * z)


@kernel
def area_vector(p: Array, q: Array, r: Array) -> tuple[float, float, float]:
    """Half the cross product of two sides: the triangle's area along its normal."""
    ax, ay, az = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    bx, by, bz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    return (0.5 * (ay * bz - az * by), 0.5 * (az * bx - ax * bz), 0.5 * (ax * by - ay * bx))


@kernel
def solid_angle(p: Array, q: Array, r: Array) -> float:
    """Signed solid angle of a triangle seen from the origin, steradians.

    The arctangent form of Van Oosterom and Strackee (1983); it keeps full precision for
    small triangles, where the form by arc cosines does not.
    """
    lp, lq, lr = norm(p), norm(q), norm(r)
    triple = (p[0] * (q[1] * r[2] - q[2] * r[1])
              + p[1] * (q[2] * r[0] - q[0] * r[2])
              + p[2] * (q[0] * r[1] - q[1] * r[0]))
    below = lp * lq * lr + dot(p, q) * lr + dot(p, r) * lq + dot(q, r) * lp
    return 2.0 * math.atan2(triple, below)
