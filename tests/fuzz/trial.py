"""What became of one input."""

from __future__ import annotations

import time
import traceback
from typing import NamedTuple

import numpy as np

from ros_pose_stats import PoseStatsError, part_from_mesh

from .closeness import undecided
from .invariants import faults
from .meshes import KINDS, case
from .sameness import differences


class Outcome(NamedTuple):
    """What became of one input.

    Attributes
    ----------
    kind : str
    seed : int
    refusal : str
        What would have been accepted; empty where the input was taken.
    faults : tuple of str
        What must not be.
    compared : str
        `same` where it was given in other ways too, or why rounding decides there.
    seconds : float
        For the part and all its answers, without being given in other ways.
    """

    kind: str
    seed: int
    refusal: str = ""
    faults: tuple[str, ...] = ()
    compared: str = ""
    seconds: float = 0.0


def attempt(kind: str, seed: int, thorough: bool = False) -> Outcome:
    """Make an input, hand it over, and judge what comes of it.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    seed : int
    thorough : bool
        Whether to ask at every tolerance, and give the body in other ways too where its kind
        allows that.
    """
    begin = time.perf_counter()
    refusal, compared, found = "", "", []
    try:
        given = case(kind, seed)
        begin = time.perf_counter()
        part = part_from_mesh(given.vertices, given.triangles, **given.options)
        found = list(faults(part, np.random.default_rng(seed), thorough))
        seconds = time.perf_counter() - begin
        if thorough and KINDS[kind].same:
            compared = undecided(part) or "same"
            found += [f"{name}: {what}" for name, what
                      in differences(part, np.random.default_rng(seed))]
    except PoseStatsError as error:
        seconds = time.perf_counter() - begin
        refusal = f"{type(error).__name__}: expected {error.expected}"
        if len(str(error).splitlines()) != 1:
            found.append("a refusal of several lines")
    except Exception as error:
        seconds = time.perf_counter() - begin
        place = traceback.extract_tb(error.__traceback__)[-1]
        found.append(f"{type(error).__name__}: {error} ({place.name}, line {place.lineno})")
    fate = KINDS[kind].fate
    if refusal and fate == "taken":
        found.append(f"refused: {refusal}")
    if not refusal and not found and fate == "refused":
        found.append("taken")
    return Outcome(kind, seed, refusal, tuple(found), compared, seconds)
