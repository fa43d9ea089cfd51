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

"""How far a changed part meets its goal, and which poses it has."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...core.estimators import ESTIMATORS, expected
from ...core.records import Index
from ...core.resting.poses import RestingPoses, bare_poses
from . import changes, paired_drops
from .goal import Wanted, find_goal


class GoalModel:
    """How far a part meets its goal, by the fast estimator, whatever is changed on it.

    A part that is changed is released from the height of the one before.
    """

    def __init__(self, space: changes.DesignSpace, wanted: Wanted) -> None:
        self.space = space
        resting = space.resting
        body = space.body
        self.scene = replace(
            space.scene, drop_height=space.scene.release_height(body.radius)
        )
        self._function = ESTIMATORS[
            expected.best_method(self.scene.restitution)
        ].function
        self.goal = find_goal(wanted, len(resting.poses))
        equilibria = resting.equilibria
        # of each face (F,): the pose that it descends to, and whether that pose rests
        # on it; facets that the part rolls on are one with the stable ones among them
        self._pose_of_face = resting.pose_of_face
        run = body.run_of_face
        self._is_resting = np.isin(run, np.setdiff1d(run[equilibria.faces], [-1]))
        self._is_resting[equilibria.faces] = True
        self._downs = resting.downs

    def estimate(self, changed_part: changes.ChangedPart) -> float:
        """How far a changed part meets the goal, 0 to 1."""
        resting = bare_poses(changed_part.part, self.scene)
        class_shares = np.bincount(
            self._classes(resting, changed_part.origin),
            self._function(resting, self.scene),
            minlength=self.goal.shares.size,
        )
        return self.goal.fulfilment(class_shares.astype(np.float64))

    def lost_poses(self, changed_part: changes.ChangedPart) -> tuple[int, ...]:
        """Wanted poses that a changed part has no more."""
        resting = bare_poses(changed_part.part, self.scene)
        return tuple(
            np.setdiff1d(
                self.goal.wanted_poses,
                self._poses_before(resting, changed_part.origin),
            ).tolist()
        )

    def pair_drops(
        self,
        changed_parts: Sequence[changes.ChangedPart],
        seed: int,
        workers: int,
        should_stop: Callable[[], bool],
    ) -> paired_drops.PairedDrops:
        """Changed parts (V) that are to be dropped from the same starts."""
        return paired_drops.PairedDrops(
            [part.part for part in changed_parts],
            self.scene,
            seed,
            workers,
            should_stop,
        )

    def classes(
        self,
        pairs: paired_drops.PairedDrops,
        changed_parts: Sequence[changes.ChangedPart],
    ) -> Index:
        """Classes of poses (V, n) in which changed parts came to rest.

        Starts count from which all did.
        """
        outcome = pairs.outcome[:, pairs.is_settled]
        return np.array(
            [
                self._classes(resting, part.origin)[poses]
                for resting, part, poses in zip(
                    pairs.resting, changed_parts, outcome, strict=True
                )
            ]
        )

    def _classes(self, resting: RestingPoses, origin: Index) -> Index:
        """Class of each pose (P,) of a changed part; a new one is not wanted."""
        old_poses = self._poses_before(resting, origin)
        return np.where(old_poses >= 0, self.goal.class_of_pose[old_poses], 0)

    def _poses_before(self, resting: RestingPoses, origin: Index) -> Index:
        """Old pose that each pose (P,) of a changed part is; -1 for a new one."""
        lowest = resting.equilibria.faces[resting.clusters.lowest_face]
        face = origin[lowest]
        old_poses = np.where(self._is_resting[face], self._pose_of_face[face], -1)
        # A pose that lost its face is the nearest of those that now rest on one that
        # led to it.
        descended = np.where(old_poses < 0, self._pose_of_face[face], -1)
        downs = resting.body.arrays.normal[lowest]
        for pose in np.setdiff1d(descended[descended >= 0], old_poses).tolist():
            candidates = np.flatnonzero(descended == pose)
            old_poses[candidates[(downs[candidates] @ self._downs[pose]).argmax()]] = (
                pose
            )
        return old_poses
