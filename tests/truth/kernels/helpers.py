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

"""Helpers of the kernels called by themselves, their machine code kept on the disk.

In the package they are compiled into the kernels that call them, and that code is kept.
"""

import hashlib

from ros_pose_stats.core.kernels import elementary, sorting, vectors
from ros_pose_stats.core.kernels.compilation import OPTIONS
from ros_pose_stats.core.kernels.drops import (
    evolve,
    free_rotation,
    impacts,
    roots,
    series,
)
from ros_pose_stats.core.kernels.levels import right_triangles, splits
from ros_pose_stats.core.kernels.machine_code import (
    KernelDispatcher,
    KernelFile,
    config,
)


class StoredHelper(KernelDispatcher):
    """A helper with a file of machine code for each signature that it is called by."""

    def compile(self, sig):
        signature = hashlib.sha256(str(sig).encode()).hexdigest()[:12]
        name = f"{self.py_func.__module__}.{self.py_func.__qualname__}"
        self._cache = KernelFile(f"{name}-{signature}")
        return super().compile(sig)


def stored(helper):
    """The helper, compiled once for all runs; as it is where numba does not compile."""
    if config.DISABLE_JIT:
        return helper
    return StoredHelper(helper.py_func, targetoptions=dict(OPTIONS))


arctangent = stored(elementary.arctangent)
exponential = stored(elementary.exponential)
rough_root = stored(elementary.rough_root)
sine_cosine = stored(elementary.sine_cosine)

falling_order = stored(sorting.falling_order)
rising_order = stored(sorting.rising_order)

area_vector = stored(vectors.area_vector)
cross = stored(vectors.cross)
dot = stored(vectors.dot)
inverse_of = stored(vectors.inverse_of)
solid_angle = stored(vectors.solid_angle)
transform = stored(vectors.transform)

faces_below = stored(splits.faces_below)
measure_triangles = stored(right_triangles.measure_triangles)

advance_state = stored(evolve.advance_state)
first_zero = stored(roots.first_zero)
free_series = stored(series.free_series)
rotate_freely = stored(free_rotation.rotate_freely)
shorten_series = stored(series.shorten_series)
sliding_series = stored(series.sliding_series)
strike_vertex = stored(impacts.strike_vertex)
vertex_velocity = stored(impacts.vertex_velocity)
