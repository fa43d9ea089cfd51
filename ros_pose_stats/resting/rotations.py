"""The proper rotations that carry a part, its surface and its inertia into themselves."""

from __future__ import annotations

from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from ..records import Part
from .equilibria import Equilibria
from .surface_trial import SurfaceTrial
from .symmetry import MOST_EFFORT, MOST_FACES, candidates, frame_of, kinds_of

Array = NDArray[np.float64]


def proper_rotations(part: Part, found: Equilibria) -> Array:
    """Rotation group of a part.

    Each rotation takes a stable face to one of its kind, so that those of the rarest kind tell
    them all. In doubt, and where there are too many to try, there is the identity alone.

    Returns (k, 3, 3): the identity first.
    """
    identity = np.eye(3)[None]
    if found.order.shape[0] > MOST_FACES:
        return identity
    kind = kinds_of(found)
    frames = lru_cache(maxsize=None)(partial(frame_of, found))
    trial = SurfaceTrial(part, found.body)
    rarest = np.flatnonzero(kind == np.bincount(kind).argmin())
    held = []
    for other in rarest.tolist():
        for rotation in candidates(frames, int(rarest[0]), other):
            if trial.effort > MOST_EFFORT:
                return identity
            if trial.holds(rotation):
                held.append(rotation)
    return np.concatenate((identity, np.array(held).reshape(-1, 3, 3)))
