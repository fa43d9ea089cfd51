"""The share of wanted poses of a changed part, and which poses they are."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...core.estimators import ESTIMATORS, expected
from ...core.records import Index, Mask
from ...core.resting.poses import RestingPoses, bare_poses
from ...core.simulation.request import DropRequest
from ...core.statistics import errors, feeding
from . import changes, paired_drops


def count_share(happened: Mask) -> feeding.Bounded:
    """How often something happened, with its 90 % interval."""
    count = int(happened.sum())
    total = happened.size
    low, high = errors.jeffreys_interval(count, total)
    return feeding.Bounded(count / total if total else 0.0, float(low), float(high))


class WantedShare:
    """Share of some poses of a part, by the fast estimator, whatever is changed on it.

    A part that is changed is released from the height of the one before.
    """

    def __init__(self, space: changes.DesignSpace, wanted_poses: Sequence[int]) -> None:
        resting = space.resting
        body = space.body
        self.scene = replace(
            space.scene, drop_height=space.scene.release_height(body.radius)
        )
        self._function = ESTIMATORS[
            expected.best_method(self.scene.restitution)
        ].function
        self.is_wanted = feeding.check_wanted_poses(wanted_poses, len(resting.poses))
        self.wanted_poses = tuple(np.flatnonzero(self.is_wanted).tolist())  # rising
        equilibria = resting.equilibria
        # of each face (F,): the pose that it descends to, and whether that pose rests
        # on it; facets that the part rolls on are one with the stable ones among them
        self._pose_of_face = resting.pose_of_face
        run = body.run_of_face
        self._is_resting = np.isin(run, np.setdiff1d(run[equilibria.faces], [-1]))
        self._is_resting[equilibria.faces] = True
        self._downs = resting.downs

    def estimate(self, changed_part: changes.ChangedPart) -> float:
        """Share of the wanted poses of a changed part, 0 to 1."""
        resting = bare_poses(changed_part.part, self.scene)
        share = self._function(resting, self.scene)
        return float(share[self._is_accepted(resting, changed_part.origin)].sum())

    def lost_poses(self, changed_part: changes.ChangedPart) -> tuple[int, ...]:
        """Wanted poses that a changed part has no more."""
        resting = bare_poses(changed_part.part, self.scene)
        return tuple(
            np.setdiff1d(
                self.wanted_poses, self._poses_before(resting, changed_part.origin)
            ).tolist()
        )

    def drop(
        self,
        changed_parts: Sequence[changes.ChangedPart],
        request: DropRequest,
        on_progress: Callable[[int], object],
        should_stop: Callable[[], bool],
        first: int = 0,
    ) -> Mask:
        """Whether changed parts (V, n), dropped from the same starts, rest as wanted.

        `first`: drops of the seed that are passed over; starts count from which all
        came to rest.
        """
        pairs = paired_drops.PairedDrops(
            [part.part for part in changed_parts],
            self.scene,
            request.seed,
            request.workers,
            should_stop,
            first=first,
        )
        pairs.drop_until(request.drops, on_progress)
        return np.array(
            [
                pairs.is_in(
                    number, np.flatnonzero(self._is_accepted(resting, part.origin))
                )
                for number, (resting, part) in enumerate(
                    zip(pairs.resting, changed_parts, strict=True)
                )
            ]
        )

    def _is_accepted(self, resting: RestingPoses, origin: Index) -> Mask:
        """Which poses (P,) of a changed part are wanted."""
        old_poses = self._poses_before(resting, origin)
        return (old_poses >= 0) & self.is_wanted[old_poses]

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
