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

"""Where to push: changes that drops show to gain most, and the faces they are of."""

import base64
from typing import NamedTuple

import numpy as np

from ...base.text import points
from ...core.mesh.decimation import visible_triangles
from ..design import describe
from ..design.sensitivity import Sensitivity
from ..plots.changes import triangle_colors

MOST_LISTED = 3


class Pushes(NamedTuple):
    """What the page says of changes of a version."""

    gains: tuple[tuple[str, str], ...]  # steps and what they gain, in words
    summary: str  # of all, where nothing is sure
    judged: str  # by what
    colors: str  # of the triangles of the view, as of `News`


def describe_pushes(sensitivities: Sensitivity) -> Pushes:
    """The best changes in words, and all that gain as colours."""
    space = sensitivities.space
    triangles = visible_triangles(space.part) - space.part.center_of_mass
    levels = np.rint(255.0 * triangle_colors(sensitivities, triangles))
    return Pushes(
        tuple(
            (
                describe.name_step(space, effect.number, effect.step),
                f"{points(check.value)} points "
                f"({points(check.low)} to {points(check.high)})",
            )
            for effect, check in sensitivities.gains[:MOST_LISTED]
        ),
        sensitivities.describe_gain(),
        describe.JUDGED,
        base64.b64encode(levels.astype(np.uint8).tobytes()).decode(),
    )
