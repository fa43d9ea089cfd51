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

"""Budden's dice, fifteen square prisms rolled by a class."""

from collections.abc import Iterable
from typing import NamedTuple

from ros_pose_stats.core.mesh.parts import part_from_mesh
from ros_pose_stats.core.records import Part, StablePose

from .shapes import box

SOURCE = (
    "Budden, 1980; table in Mungan and Lipscombe, Mathematical Gazette 97 (2013), "
    "note 97.16"
)


class Die(NamedTuple):
    """A square prism that was rolled.

    Attributes
    ----------
    ratio : float
        Length over width: the third side over the side of the square.
    on_squares : float
        Frequency of the two square faces together, as published, 0 to 1.
    rolls : int
    """

    ratio: float
    on_squares: float
    rolls: int

    @property
    def on_sides(self) -> float:
        """Frequency of the four sides together, 0 to 1."""
        return 1.0 - self.on_squares

    @property
    def rolls_on_sides(self) -> int:
        """Rolls that ended on a side: the whole number that the published frequency
        rounds.
        """
        return self.rolls - round(self.on_squares * self.rolls)


DICE = (
    Die(0.47, 0.916, 332),
    Die(0.63, 0.738, 840),
    Die(0.75, 0.548, 799),
    Die(0.81, 0.496, 740),
    Die(0.93, 0.399, 516),
    Die(0.97, 0.385, 530),
    Die(1.16, 0.148, 1011),
    Die(1.23, 0.154, 532),
    Die(1.44, 0.052, 654),
    Die(1.55, 0.040, 606),
    Die(1.60, 0.017, 702),
    Die(1.71, 0.031, 609),
    Die(1.87, 0.009, 680),
    Die(2.12, 0.007, 275),
    Die(2.65, 0.006, 503),
)
"""The dice by rising ratio; the source is `SOURCE`."""

WIDTH = 0.01
"""Side of the square, metres. No result depends on it: drops start at a multiple of the
radius.
"""

SQUARE_FACE = 0.9
"""A pose with a larger |down_z| lies on a square face; sides have 0, square faces 1."""


def square_prism(ratio: float) -> Part:
    """Square prism along z of the given length over width, homogeneous."""
    return part_from_mesh(*box(WIDTH, WIDTH, ratio * WIDTH))


def on_squares(poses: Iterable[StablePose]) -> list[StablePose]:
    """The poses on a square face of a prism along z."""
    return [pose for pose in poses if abs(pose.down[2]) > SQUARE_FACE]
