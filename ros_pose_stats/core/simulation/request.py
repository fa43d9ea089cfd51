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

"""The request for a simulation, checked before anything runs, and who watches it."""

import os
import secrets
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...base.errors import RequestError
from ..mesh import arrays, vectors
from ..records import Array, DropProgress
from ..records.scene import DEFAULT_DROPS, is_whole_number, real_number

if TYPE_CHECKING:
    from .drops import DropChunk  # whose kernels are loaded where drops are made


MOST_DROPS = 1_000_000_000
SMALLEST_TARGET = 1e-6  # no number of drops keeps one; the square of a tiny one is 0
MOST_WORKERS = 1024
SEEDS = 2**64
FEWEST_DROPS = 50
"""Drops, whatever they cost, where the number of impacts and steps is bounded."""


@dataclass(frozen=True, eq=False)
class DropRequest:
    """How many drops, from which starts, and by how many threads."""

    drops: int  # most drops; all of them without a target error
    seed: int  # 0 where the starting directions are given
    target_error: float  # 0 asks for all drops
    workers: int  # threads
    starts: Array | None  # (k, 3); given starting directions, unit vectors
    # impacts and steps that all drops together may take, judged by the first
    # `FEWEST_DROPS`; 0: any
    events: int = 0


OnProgress = Callable[[DropProgress], object] | None


class Watch(NamedTuple):
    """Who follows a run of drops, and may end it."""

    # called in the caller's thread, some twenty times a second
    on_progress: OnProgress = None
    should_stop: Callable[[], bool] = lambda: False  # asked now and then
    # given all drops that count, in their order
    on_drops: "Callable[[DropChunk], object] | None" = None
    # whether workers give way to other threads of this machine
    background: bool = False

    @classmethod
    def from_callbacks(
        cls,
        on_progress: OnProgress,
        should_stop: Callable[[], bool] | None,
        *options: Any,
    ) -> "Watch":
        """From what a caller gives, or leaves out."""
        return cls(on_progress, should_stop or (lambda: False), *options)


UNWATCHED = Watch()


def drop_request(
    drops: int | None,
    seed: int | None,
    target_error: float = 0.0,
    workers: int | None = None,
    starts: ArrayLike | None = None,
) -> "DropRequest":
    """Fill in defaults and check the values."""
    target = check_target(target_error)
    threads = check_workers(workers)
    directions = None if starts is None else _check_starts(starts)
    drop_bound = _check_drops(drops, directions)
    drawn_seed = secrets.randbits(32) if seed is None else _check_integer("seed", seed)
    if not 0 <= drawn_seed < SEEDS:
        raise RequestError(
            "a seed from 0 to 2^64 - 1", f"{seed}", "leave it out for a fresh one"
        )
    if target:
        target = max(target, SMALLEST_TARGET)
    return DropRequest(
        drop_bound, drawn_seed if directions is None else 0, target, threads, directions
    )


def check_target(target_error: float) -> float:
    """The error to be reached; 0: none."""
    target = real_number("target_error", target_error)
    if not 0.0 <= target < 1.0:
        raise RequestError(
            "a target error from 0 to below 1, as a fraction",
            f"{target_error}",
            "0.01 is one point; 0 asks for none",
        )
    return target


def check_workers(workers: int | None) -> int:
    """Number of threads or processes; all cores where none is given."""
    count = (
        len(os.sched_getaffinity(0))
        if workers is None
        else _check_integer("workers", workers)
    )
    if not 1 <= count <= MOST_WORKERS:
        raise RequestError(
            f"1 to {MOST_WORKERS} workers", f"{workers}", "leave it out for all cores"
        )
    return count


def _check_drops(drops: int | None, starts: Array | None) -> int:
    if drops is None:
        return DEFAULT_DROPS if starts is None else starts.shape[0]
    bound = _check_integer("drops", drops)
    if not 1 <= bound <= MOST_DROPS:
        raise RequestError(
            f"1 to {MOST_DROPS} drops", f"{drops}", "10000 gives half a point"
        )
    if starts is not None and bound > starts.shape[0]:
        raise RequestError(
            f"at most as many drops as starts ({starts.shape[0]})",
            f"{drops}",
            "the same start gives the same drop again; give more starts",
        )
    return bound


def _check_starts(starts: ArrayLike) -> Array:
    try:
        directions = arrays.unmask(starts)
    except arrays.NOT_NUMBERS:  # ragged, or complex
        directions = np.zeros(())
    directions = arrays.real_array(
        directions if directions.dtype.kind in "fiu" else 0.0
    )
    if directions.ndim != 2 or directions.shape[0] < 1 or directions.shape[1] != 3:
        raise RequestError(
            "starts as an array (k, 3) of directions, k at least 1",
            f"shape {directions.shape}" if directions.ndim else "no array of numbers",
            "a row a drop",
        )
    largest = np.abs(directions).max(axis=1)
    invalid_rows = np.flatnonzero(~(np.isfinite(largest) & (largest > 0.0)))
    if invalid_rows.size:
        raise RequestError(
            "starts that are directions",
            f"{directions[invalid_rows[0]]} in row {invalid_rows[0]}",
            "no row may be zero, infinite or NaN",
        )
    scaled = directions / largest[:, None]  # whose squares neither overflow nor vanish
    return vectors.unit_vectors(scaled)


def _check_integer(name: str, value: Any) -> int:
    if is_whole_number(value):
        return int(value)
    raise RequestError(f"a whole number for {name}", f"{value!r}", "give an int")
