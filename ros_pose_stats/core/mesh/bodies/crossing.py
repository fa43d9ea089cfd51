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

"""How much of a volume a surface that runs through itself encloses twice.

An outline that crosses itself leaves such a surface. Vertical lines through it show how
often each of their pieces is enclosed.
"""

import math

import numpy as np

from ...kernels.mesh.upright_lines import count_pairs, enclosed_lengths
from ...records import Array, Index
from ...tolerances import OVERLAP

_LINES = 64
"""Lines along each side of the part: several of 64 x 64 meet the thousandth of a volume
that matters."""

_MOST_PAIRS = 400_000  # of lines and triangles: where all are slivers, fewer lines

# Off the simple fractions of the size where edges are drawn.
_ASIDE = np.array([math.sqrt(2.0) - 1.0, math.sqrt(3.0) - 1.0])


def share_enclosed_twice(points: Array, triangles: Index, lines: int = _LINES) -> float:
    """Share of the volume of points of size one that is enclosed twice, or inside out.

    Normals point out of the material. Less than some thousandth may be missed.
    """
    on_grid = np.column_stack(((points[:, :2] + 0.5) * lines + _ASIDE, points[:, 2]))
    pairs = count_pairs(on_grid, triangles)
    if pairs > _MOST_PAIRS and lines > 1:
        return share_enclosed_twice(points, triangles, lines // 2)
    total, wrong = enclosed_lengths(on_grid, triangles, pairs, lines + 2, OVERLAP)
    return min(wrong / total, 1.0) if total > 0.0 else 0.0
