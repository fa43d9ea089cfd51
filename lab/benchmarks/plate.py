"""A plate full of parts, simulated: thrown outlines, picks, and kicks that throw all again."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from manifold3d import CrossSection, JoinType
from numpy.random import Generator
from numpy.typing import NDArray

from ros_pose_stats import Part, StablePose, outline_at

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]


class Plate:
    """Parts of one kind with their true outlines, bays and holes included.

    A part is blocked where another one reaches into its outline grown by the clearance.
    """

    def __init__(self, part: Part, poses: Sequence[StablePose], size: tuple[float, float],
                 clearance: float) -> None:
        self.size = np.array(size)
        self.outlines = [CrossSection([ring for polygon in outline_at(part, pose)
                                       for ring in polygon]) for pose in poses]
        self.grown = [outline.offset(clearance, JoinType.Round, circular_segments=48)
                      for outline in self.outlines]
        self.reach = np.array([max(np.hypot(*ring.T).max() for ring in outline.to_polygons())
                               for outline in self.outlines])
        self.clearance = clearance

    def free(self, pose: Index, wanted: Flags, random: Generator) -> Flags:
        """Throw parts (N,) that come to rest in these poses; which of those wanted are free."""
        place = random.uniform(size=(len(pose), 2)) * self.size
        turn = random.uniform(0.0, 360.0, len(pose))
        far = self.reach[pose]
        near = (np.hypot(*(place[:, None] - place).T) < far[:, None] + far + self.clearance)
        np.fill_diagonal(near, False)
        free = wanted[pose]
        for mine in np.flatnonzero(free):
            here = self.grown[pose[mine]].rotate(turn[mine])
            free[mine] = all((here ^ self.outlines[pose[other]].rotate(turn[other]).translate(
                place[other] - place[mine])).is_empty() for other in np.flatnonzero(near[mine]))
        return free
