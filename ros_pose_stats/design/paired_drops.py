"""Variants of a part dropped from the same starts, so that the chance they share cancels.

Drop k of every variant begins with the same direction down, in the part's own frame; where a
variant is turned in the frame of its file, so is the direction.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import RequestError
from ..mesh.vectors import turn_vectors
from ..records import Array, DropScene, Index, Mask, Part
from ..resting.poses import RestingPoses, poses_in
from ..simulation import chunks, drop_body, request
from ..simulation.drops import DropOutcomes, compute_drops, drop_rules, random_starts
from ..statistics.paired_counts import PairedDifference, paired_difference

UNSETTLED = -1


@dataclass(frozen=True, eq=False)
class PairedDrops:
    """Outcomes of the same starts for several variants."""

    scene: DropScene  # with the drop height in metres, the same for all
    seed: int
    resting: tuple[RestingPoses, ...]  # of each of the V variants
    # (V, n) int; `index` of the pose in which a variant came to rest from each start; -1 where it
    # did not
    outcome: Index
    # starts from which each variant was released touching the plate; empty before the first
    touched: tuple[int, ...] = ()

    @property
    def drops(self) -> int:
        """Starts so far."""
        return int(self.outcome.shape[1])

    @property
    def settled(self) -> Mask:
        """Starts (n,) from which every variant came to rest; only these count."""
        return np.asarray((self.outcome != UNSETTLED).all(axis=0))

    def counts(self, variant: int) -> Index:
        """How often a variant came to rest in each of its poses (P,)."""
        return np.bincount(self.outcome[variant, self.settled],
                           minlength=len(self.resting[variant].poses))

    def is_in(self, variant: int, poses: Sequence[int]) -> Mask:
        """From which of the settled starts a variant came to rest in one of some poses."""
        wanted = np.zeros(len(self.resting[variant].poses), dtype=np.bool_)
        wanted[list(poses)] = True
        return np.asarray(wanted[self.outcome[variant, self.settled]])

    def difference(self, first: int, poses: Sequence[int], second: int,
                   others: Sequence[int]) -> PairedDifference:
        """Share of the `others` of variant `second` less that of the `poses` of `first`.

        Its standard error is that of the joint counts: what both have in common cancels.
        """
        return paired_difference(self.is_in(first, poses), self.is_in(second, others))


def begin_pairs(parts: Sequence[Part], scene: DropScene, seed: int) -> PairedDrops:
    """Variants that are to be dropped together, before the first drop.

    `scene`: without a drop height all are released at the same one: 20 radii of the first; `seed`:
    0 to 2^64 - 1. Drop k depends on the seed and k alone, and the first variant's are those that
    `simulate` makes of it. Raises RequestError, MeshError if there is no part, or the hull of one
    does not enclose its centre of mass.
    """
    if not parts:
        raise RequestError("at least one part to drop", "none", "give a part")
    resting = tuple(poses_in(part, scene) for part in parts)
    common = replace(scene, drop_height=scene.release_height(resting[0].body.radius))
    return PairedDrops(common, seed, resting, np.zeros((len(parts), 0), dtype=np.int64))


def drop_more(pairs: PairedDrops, parts: Sequence[Part], drops: int,
              turns: Sequence[Array | None] | None = None, workers: int | None = None,
              on_progress: Callable[[int, int], object] | None = None,
              should_stop: Callable[[], bool] | None = None) -> PairedDrops:
    """Drop all variants from the next starts.

    `pairs`: from `begin_pairs` of these parts, or from here; `drops`: how many starts there are to
    be in the end; the answer does not depend on the steps; `turns`: for each variant the rotation
    from the first one's frame to its own; None, also for all, where the frames are the same;
    `on_progress`: takes the number of drops done, and of all in this call; `should_stop`: after
    True the starts that all variants have been dropped from by then are kept. Raises RequestError
    if a number is out of its range.
    """
    asked = request.drop_request(drops, pairs.seed, 0.0, workers, None)
    done, more = pairs.drops, asked.drops - pairs.drops
    if more <= 0:
        return pairs
    directions = random_starts(asked.seed, done, more)
    rows: list[tuple[Index, Mask]] = []
    for place, part in enumerate(parts):
        turn = None if turns is None else turns[place]
        rows.append(_outcomes(
            part, pairs.scene, directions if turn is None else turn_vectors(directions, turn.T),
            asked.workers, should_stop,
            None if on_progress is None else _part_of_all(on_progress, place, len(parts), more)))
        if rows[-1][0].size < more:
            break
    kept = min(poses.size for poses, _ in rows) if len(rows) == len(parts) else 0
    if not kept:
        return pairs
    added: Index = np.stack([poses[:kept] for poses, _ in rows])
    before = pairs.touched or (0,) * len(parts)
    return replace(pairs, outcome=np.concatenate((pairs.outcome, added), axis=1), touched=tuple(
        count + int(touched[:kept].sum())
        for count, (_, touched) in zip(before, rows, strict=True)))


def _outcomes(part: Part, scene: DropScene, directions: Array, workers: int,
              should_stop: Callable[[], bool] | None,
              on_drops: Callable[[int], object] | None) -> tuple[Index, Mask]:
    """Pose (n,) from each direction, and whether it was released touching; fewer after a stop."""
    body = drop_body.drop_body(part, scene)
    rules = drop_rules(scene, body.radius)

    def drop(first: int, count: int) -> DropOutcomes:
        return compute_drops(body, rules, directions[first:first + count])

    at_work = chunks.DropWorkers(drop, len(directions), workers, should_stop or (lambda: False))
    found: list[Index] = [np.zeros(0, dtype=np.int64)]
    touched: list[Mask] = [np.zeros(0, dtype=np.bool_)]
    done = 0
    for outcomes in at_work.outcomes_in_order():
        found.append(outcomes.pose)
        touched.append(outcomes.touched)
        done += outcomes.pose.size
        if on_drops is not None:
            on_drops(done)
    return np.concatenate(found), np.concatenate(touched)


def _part_of_all(told: Callable[[int, int], object], place: int, variants: int,
                 more: int) -> Callable[[int], object]:
    return lambda done: told(place * more + done, variants * more)
