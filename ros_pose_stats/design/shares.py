"""The share of wanted poses of a changed part, and which of its poses are the ones before."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..estimators import expected, registry
from ..records import DropScene, Index, Mask
from ..resting.poses import RestingPoses, bare_poses
from ..statistics.feeding import check_wanted
from . import changes, features


class WantedShare:
    """The share of some poses of a part, by the fast estimator, whatever is changed on it.

    `wanted`: indices of the poses that are accepted; `scene`: a part that is changed is released
    from the height of the one before. Raises RequestError if there is no such pose.
    """

    def __init__(self, space: changes.DesignSpace, wanted: Sequence[int],
                 scene: DropScene) -> None:
        self.scene = replace(scene, drop_height=scene.release_height(space.body.radius))
        self._function = registry.ESTIMATORS[expected.best_method(scene.restitution)].function
        self.kept = check_wanted(wanted, len(space.resting.poses))
        self._pose, self._rests = features.pose_of_faces(space.resting)
        self._downs = np.array([pose.down for pose in space.resting.poses])

    def estimate(self, changed: changes.ChangedPart) -> float:
        """Share of the wanted poses of a changed part, 0 to 1."""
        resting = bare_poses(changed.part, self.scene)
        share = self._function(resting, self.scene)
        return float(share[self.accepted(resting, changed.origin)].sum())

    def lost(self, changed: changes.ChangedPart) -> tuple[int, ...]:
        """Wanted poses that a changed part has no more."""
        resting = bare_poses(changed.part, self.scene)
        there = self.poses_before(resting, changed.origin)
        return tuple(np.setdiff1d(np.flatnonzero(self.kept), there).tolist())

    def accepted(self, resting: RestingPoses, origin: Index) -> Mask:
        """Which poses (P,) of a changed part are wanted."""
        before = self.poses_before(resting, origin)
        return np.asarray((before >= 0) & self.kept[before])

    def poses_before(self, resting: RestingPoses, origin: Index) -> Index:
        """Pose of the part before that each pose (P,) of a changed part is; -1 for a new one.

        A pose is the one that rests on the same face. Where a pose has lost its face, as on a
        surface of many facets, it is the nearest of those that now rest on a face that led to it.
        """
        lowest = resting.equilibria.faces[resting.clusters.lowest]
        face = origin[lowest]
        before = np.where(self._rests[face], self._pose[face], -1)
        led = np.where(before < 0, self._pose[face], -1)
        downs = resting.body.arrays.normal[lowest]
        for pose in np.setdiff1d(led[led >= 0], before).tolist():
            some = np.flatnonzero(led == pose)
            before[some[(downs[some] @ self._downs[pose]).argmax()]] = pose
        return np.asarray(before)
