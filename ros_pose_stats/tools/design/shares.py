"""The share of wanted poses of a changed part, and which of its poses are the ones before."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...core.estimators import ESTIMATORS, expected
from ...core.records import Index, Mask
from ...core.resting.poses import RestingPoses, bare_poses
from ...core.statistics import errors, feeding
from . import changes, paired_drops


def counted_share(happened: Mask) -> feeding.Bounded:
    """How often something happened, with its 90 % interval."""
    count = int(happened.sum())
    total = happened.size
    low, high = errors.jeffreys_interval(count, total)
    return feeding.Bounded(count / total if total else 0.0, float(low), float(high))


class WantedShare:
    """Share of some poses of a part, by the fast estimator, whatever is changed on it.

    A part that is changed is released from the height of the one before.
    """

    def __init__(self, space: changes.DesignSpace, wanted: Sequence[int]) -> None:
        resting = space.resting
        body = space.body
        self.scene = replace(
            space.scene, drop_height=space.scene.release_height(body.radius)
        )
        self._function = ESTIMATORS[
            expected.best_method(self.scene.restitution)
        ].function
        self.kept: Mask = feeding.check_wanted(wanted, len(resting.poses))
        self.wanted: tuple[int, ...] = tuple(
            np.flatnonzero(self.kept).tolist()
        )  # rising
        found = resting.equilibria
        # of each face (F,): the pose that it descends to, and whether that pose rests on it;
        # facets that the part rolls on are one with the stable ones among them
        self._pose: Index = resting.pose_of_face
        strip = body.run_of_face
        self._rests = np.isin(strip, np.setdiff1d(strip[found.faces], [-1]))
        self._rests[found.faces] = True
        self._downs = resting.downs

    def estimate(self, changed: changes.ChangedPart) -> float:
        """Share of the wanted poses of a changed part, 0 to 1."""
        resting = bare_poses(changed.part, self.scene)
        share = self._function(resting, self.scene)
        return float(share[self._accepted(resting, changed.origin)].sum())

    def lost(self, changed: changes.ChangedPart) -> tuple[int, ...]:
        """Wanted poses that a changed part has no more."""
        resting = bare_poses(changed.part, self.scene)
        return tuple(
            np.setdiff1d(self.wanted, self._before(resting, changed.origin)).tolist()
        )

    def drop(
        self,
        changed: Sequence[changes.ChangedPart],
        drops: int,
        seed: int,
        workers: int,
        on_progress: Callable[[int], object] = lambda done: None,
        should_stop: Callable[[], bool] = lambda: False,
        first: int = 0,
    ) -> Mask:
        """Whether each changed part (V, n), dropped from the same starts, rests as is wanted.

        `first`: drops of the seed that are passed over; starts count from which all came to rest.
        """
        pairs = paired_drops.PairedDrops(
            [one.part for one in changed],
            self.scene,
            seed,
            workers,
            should_stop,
            first=first,
        )
        pairs.drop_until(drops, on_progress)
        return np.array(
            [
                pairs.is_in(
                    place, np.flatnonzero(self._accepted(resting, one.origin)).tolist()
                )
                for place, (resting, one) in enumerate(
                    zip(pairs.resting, changed, strict=True)
                )
            ]
        )

    def _accepted(self, resting: RestingPoses, origin: Index) -> Mask:
        """Which poses (P,) of a changed part are wanted."""
        before = self._before(resting, origin)
        return np.asarray((before >= 0) & self.kept[before])

    def _before(self, resting: RestingPoses, origin: Index) -> Index:
        """Pose of the part before that each pose (P,) of a changed part is; -1 for a new one."""
        lowest = resting.equilibria.faces[resting.clusters.lowest_face]
        face = origin[lowest]
        before = np.where(self._rests[face], self._pose[face], -1)
        # A pose that lost its face is the nearest of those that now rest on one that led to it.
        led = np.where(before < 0, self._pose[face], -1)
        downs = resting.body.arrays.normal[lowest]
        for pose in np.setdiff1d(led[led >= 0], before).tolist():
            some = np.flatnonzero(led == pose)
            before[some[(downs[some] @ self._downs[pose]).argmax()]] = pose
        return np.asarray(before)
