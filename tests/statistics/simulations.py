"""Made-up bodies whose exact probabilities are known, and simulations of them."""

from __future__ import annotations

import numpy as np

from ros_pose_stats.statistics.prefix import next_checkpoint
from ros_pose_stats.study.errors.simulated_poses import SimulatedPoses


def bodies(rng, number, strength=1.0):
    """Numbers of the bodies and exact probabilities; 2 to 8 poses a body, 5 in the mean."""
    poses = rng.integers(2, 9, number)
    return (np.arange(number).repeat(poses),
            np.concatenate([rng.dirichlet(np.full(k, strength)) for k in poses]))


def simulated(rng, body, p, drops):
    """Independent drops of each body; `drops` is a number, or one for each body."""
    pieces = np.split(p, np.flatnonzero(np.diff(body)) + 1)
    each = np.broadcast_to(drops, len(pieces))
    count = np.concatenate([rng.multinomial(n, q) for n, q in zip(each, pieces, strict=True)])
    return SimulatedPoses(body, count, each.repeat([len(q) for q in pieces]))


def checkpoints(drops):
    """All prefixes at which a run of at most so many drops is looked at; the last is `drops`."""
    done = 0
    while done < drops:
        done = next_checkpoint(done, drops)
        yield done
