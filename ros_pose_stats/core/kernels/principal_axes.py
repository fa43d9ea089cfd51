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

"""Principal axes of symmetric tensors, alike on every processor.

LAPACK and BLAS choose their code by the processor, and with it how they round. A drop
follows the axes of its part to the last bit, above all where two moments are equal but
for rounding.
"""

import math

import numpy as np

from .array_types import Array, Fixed2
from .compilation import entry_kernel, kernel
from .vectors import dot, point_at, transform

_SWEEPS = 12
"""Convergence is quadratic: five sweeps do for any tensor of doubles."""

_NEGLIGIBLE = 2.0**-53
"""Entries below this share of both diagonal ones are lost in their rounding."""

_PAIRS = ((0, 1, 2), (0, 2, 1), (1, 2, 0))


@entry_kernel
def is_kept(tensor: Fixed2, rotation: Fixed2, tolerance: float) -> bool:
    """Whether a rotation keeps a symmetric tensor, within a share of its trace."""
    return keeps_tensor(rotation, tensor, tolerance)


@kernel
def keeps_tensor(rotation: Array, tensor: Array, tolerance: float) -> bool:
    """The same for kernels."""
    largest_difference = tolerance * (tensor[0, 0] + tensor[1, 1] + tensor[2, 2])
    for i in range(3):
        row = point_at(rotation, i)
        for j in range(3):
            image = transform(tensor, point_at(rotation, j))
            if abs(dot(row, image) - tensor[i, j]) > largest_difference:
                return False
    return True


@entry_kernel
def principal_axes(tensor: Fixed2) -> tuple[Array, Array]:
    """Rising eigenvalues and right-handed eigenvectors as columns, by Jacobi.

    Golub and Van Loan, Matrix Computations, section 8.5. In the first two the largest
    component is positive.
    """
    a = tensor.copy()
    axes = np.eye(3)
    for _ in range(_SWEEPS):
        if a[0, 1] == 0.0 and a[0, 2] == 0.0 and a[1, 2] == 0.0:
            break
        for p, q, third in _PAIRS:
            _annihilate(a, axes, p, q, third)
    moment = np.array([a[0, 0], a[1, 1], a[2, 2]])
    _order_axes(moment, axes)
    return moment, axes


@kernel
def _annihilate(a: Array, axes: Array, p: int, q: int, third: int) -> None:
    """Turn the axes p < q so that the entry (p, q) vanishes."""
    entry = a[p, q]
    a[p, q] = 0.0
    if abs(entry) <= _NEGLIGIBLE * min(abs(a[p, p]), abs(a[q, q])):
        return
    # Where its square overflows, the tangent is 0 and nothing turns.
    theta = 0.5 * (a[q, q] - a[p, p]) / entry
    t = math.copysign(1.0, theta) / (abs(theta) + math.sqrt(theta * theta + 1.0))
    c = 1.0 / math.sqrt(t * t + 1.0)
    s = t * c
    a[p, p] -= t * entry
    a[q, q] += t * entry
    i = min(p, third)
    j = max(p, third)
    k = min(q, third)
    m = max(q, third)
    a[i, j], a[k, m] = c * a[i, j] - s * a[k, m], s * a[i, j] + c * a[k, m]
    for r in range(3):
        axes[r, p], axes[r, q] = (
            c * axes[r, p] - s * axes[r, q],
            s * axes[r, p] + c * axes[r, q],
        )


@kernel
def _order_axes(moment: Array, axes: Array) -> None:
    """Sort by rising moment, equal ones as they stand; set lengths and signs."""
    for i, j in ((0, 1), (1, 2), (0, 1)):
        if moment[i] > moment[j]:
            moment[i], moment[j] = moment[j], moment[i]
            for r in range(3):
                axes[r, i], axes[r, j] = axes[r, j], axes[r, i]
    for i in range(2):
        length = 0.0
        largest = 0
        for r in range(3):
            length += axes[r, i] * axes[r, i]
            if abs(axes[r, i]) > abs(axes[largest, i]):
                largest = r
        length = math.copysign(math.sqrt(length), axes[largest, i])
        for r in range(3):
            axes[r, i] /= length
    for r in range(3):
        i = (r + 1) % 3
        j = (r + 2) % 3
        axes[r, 2] = axes[i, 0] * axes[j, 1] - axes[j, 0] * axes[i, 1]
