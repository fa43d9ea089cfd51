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

"""What parts take in memory, counted in a process that needs little to begin."""

import gc
import pickle
import tracemalloc

import numpy as np

from ros_pose_stats import estimate, part_from_mesh, simulate
from ros_pose_stats.core.mesh.decimation import visible_triangles
from ros_pose_stats.core.records.part import memory_bytes

PARTS = 2
DRAWN = 1000


def used_part(surface):
    """A part with what a node prepares of it."""
    part = part_from_mesh(*surface)
    estimate(part, "split")
    simulate(part, 20, seed=1)
    visible_triangles(part, DRAWN)
    return part


def sent_part(surface):
    """The same as it comes out of another process."""
    part = used_part(surface)
    twin, prepared = pickle.loads(pickle.dumps((part, part.all_prepared()), 5))
    twin.keep_all(prepared)
    return twin


def weigh(surface, make):
    """Bytes of some parts as they are told, and as Python has counted them."""
    make(surface)  # brings what all parts share
    tracemalloc.start()
    try:
        gc.collect()
        before = tracemalloc.get_traced_memory()[0]
        parts = [
            make((factor * surface[0], surface[1].copy()))
            for factor in np.linspace(1.0, 1.1, PARTS)
        ]
        gc.collect()
        taken = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    return sum(map(memory_bytes, parts)), taken
