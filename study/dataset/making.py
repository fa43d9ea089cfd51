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

"""Makes a dataset piece by piece, on this machine's cores or on a cluster's."""

import time
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from threading import Event

import numpy as np

from lab.bodies.random_polyhedra import RandomPolyhedron, random_polyhedron
from ros_pose_stats.core.records import DropScene, Index
from ros_pose_stats.core.simulation.drop_body import PreparedBody, body_in_part_axes
from ros_pose_stats.core.simulation.drops import (
    compute_drops,
    drop_rules,
    random_starts,
)
from ros_pose_stats.core.simulation.request import check_workers
from ros_pose_stats.tools.batch.processes import in_flight

from .archive import Arrays, read_archive, write_archive
from .spec import DatasetError, DatasetSpec
from .unfinished import Unfinished, clear_leftovers

Piece = tuple[int, int]
Made = tuple[Piece, Arrays]
Maker = Callable[
    [DatasetSpec, Sequence[Piece], Callable[[], bool]], Generator[Made, None, None]
]
"""Makes the pieces of a specification and yields each when it is done, until told to
stop.
"""


@dataclass(frozen=True)
class DatasetProgress:
    """State of a run.

    Attributes
    ----------
    bodies, bound : int
        Done in all, and wanted.
    found : int
        Number of those that were there when this run began.
    seconds : float
        Since this run began.
    """

    bodies: int
    bound: int
    earlier_bodies: int
    seconds: float


def make_dataset(
    file: Path,
    spec: DatasetSpec,
    maker: Maker,
    *,
    on_progress: Callable[[DatasetProgress], object] = lambda _: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> bool:
    """Make a dataset, or go on where an earlier run was cut off.

    Parameters
    ----------
    file : Path
        Written when everything is done; until then the pieces lie in
        `<file>.unfinished`. If the same dataset stands there, nothing is done.
    spec : DatasetSpec
    maker : callable
        `on_threads(n)`, or `on_cluster(address)` of `cluster`; the results are the
        same.
    on_progress : callable, optional
        Called with a `DatasetProgress` after each piece.
    should_stop : callable, optional
        Asked some twenty times a second; True ends the run with the pieces that are
        done.

    Returns
    -------
    bool
        Whether the dataset is complete.

    Raises
    ------
    DatasetError
        If another dataset or other pieces are in the way, or nothing can be written.
    """
    if _is_complete(file, spec):
        clear_leftovers(file, spec)
        return True
    with Unfinished(file, spec) as unfinished:
        if _is_complete(file, spec):  # another run finished just now
            unfinished.remove()
            return True
        sound_pieces = unfinished.sound_pieces()
        begin = time.monotonic()
        earlier_bodies = sum(count for _, count in sound_pieces)
        bodies = earlier_bodies
        on_progress(DatasetProgress(bodies, spec.bodies, earlier_bodies, 0.0))
        missing = [piece for piece in spec.chunks if piece not in set(sound_pieces)]
        with closing(maker(spec, missing, should_stop)) as new_pieces:
            for piece, arrays in new_pieces:
                unfinished.store_piece(piece, arrays)
                bodies += piece[1]
                on_progress(
                    DatasetProgress(
                        bodies, spec.bodies, earlier_bodies, time.monotonic() - begin
                    )
                )
        if bodies < spec.bodies:
            return False
        write_archive(file, spec, unfinished.pieces())
        unfinished.remove()
    return True


def _is_complete(file: Path, spec: DatasetSpec) -> bool:
    """Whether the dataset is done; refuses a file that holds something else."""
    try:
        if not file.exists():
            return False
    except OSError as error:
        raise DatasetError(
            "a file name that the file system takes",
            f"{file} ({error.strerror})",
            "name another one with -o",
        ) from error
    stored, _ = read_archive(file)
    if stored != spec:
        others = ", ".join(
            f"{name} {value}"
            for name, value in stored.as_dict().items()
            if value != spec.as_dict()[name]
        )
        raise DatasetError(
            "a file that is not there yet, or the same dataset",
            f"another one in {file} ({others})",
            "name another file with -o",
        )
    return True


def on_threads(workers: int | None = None) -> Maker:
    """Pieces made by threads of this process; the kernels run without the interpreter's
    lock.

    Parameters
    ----------
    workers : int, optional
        Threads; default: all cores.
    """
    threads = check_workers(workers)

    def make(
        spec: DatasetSpec, pieces: Sequence[Piece], should_stop: Callable[[], bool]
    ) -> Generator[Made, None, None]:
        ended = Event()
        with ThreadPoolExecutor(threads) as pool:
            try:
                yield from in_flight(
                    lambda piece: pool.submit(make_chunk, spec, *piece, ended.is_set),
                    lambda future, _: future.result(),
                    pieces,
                    should_stop,
                    lambda: 2 * threads,
                )
            finally:
                ended.set()
                pool.shutdown(wait=False, cancel_futures=True)

    return make


AT_ONCE = 1000
"""Drops in one call of the kernel, which nothing can interrupt: about half a second."""


class Stopped(Exception):  # noqa: N818 - no error
    """A piece was given up because somebody asked for it."""


def make_chunk(
    spec: DatasetSpec,
    first: int,
    count: int,
    should_stop: Callable[[], bool] = lambda: False,
) -> Arrays:
    """Draw bodies and drop them.

    Parameters
    ----------
    spec : DatasetSpec
    first, count : int
        Bodies first ... first + count - 1.
    should_stop : callable, optional
        Asked about every half a second.

    Returns
    -------
    dict of arrays
        Those of `archive.FIELDS` for these bodies alone. They depend on the arguments
        and on nothing else, whoever computes them.

    Raises
    ------
    Stopped
        If `should_stop` says so.
    """
    bodies = [
        random_polyhedron(spec.seed, number, spec.shift, spec.shift_moment)
        for number in range(first, first + count)
    ]
    scene = DropScene(cluster_tolerance=0.0, round_sides=0)
    prepared = [body_in_part_axes(body.part(), scene) for body in bodies]
    counts = [
        _counts(spec, first + k, one, should_stop) for k, one in enumerate(prepared)
    ]
    poses = [pose for one in prepared for pose in one.resting.poses]
    return {
        **_surfaces(bodies),
        "redraws": np.array([body.redraws for body in bodies], dtype=np.uint32),
        "poses": np.array(
            [len(one.resting.poses) for one in prepared], dtype=np.uint32
        ),
        "down": np.array([pose.down for pose in poses]),
        "height": np.array([pose.height for pose in poses]),
        "count": np.concatenate(counts).astype(np.uint32),
        "settled": np.stack([one.sum(axis=0) for one in counts]).astype(np.uint32),
    }


def _surfaces(bodies: list[RandomPolyhedron]) -> Arrays:
    return {
        "vertices": np.array([len(body.vertices) for body in bodies], dtype=np.uint32),
        "triangles": np.array(
            [len(body.triangles) for body in bodies], dtype=np.uint32
        ),
        "vertex": np.concatenate([body.vertices for body in bodies]),
        "triangle": np.concatenate([body.triangles for body in bodies]).astype(
            np.uint32
        ),
        "center_of_mass": np.array([body.center_of_mass for body in bodies]),
    }


def _counts(
    spec: DatasetSpec, number: int, body: PreparedBody, should_stop: Callable[[], bool]
) -> Index:
    """Drops in each pose, at each restitution, in each block (P, R, K)."""
    ends = spec.block_ends
    shape = len(body.resting.poses), len(spec.restitutions), len(ends)
    counts = np.zeros(shape, dtype=np.int64)
    for k, restitution in enumerate(spec.restitutions):
        rules = drop_rules(
            DropScene(restitution, spec.drop_height, 0.0, 0), body.radius
        )
        seed = spec.drop_seed(number, restitution)
        for start in range(0, spec.drops, AT_ONCE):
            if should_stop():
                raise Stopped
            starts = random_starts(seed, start, min(AT_ONCE, spec.drops - start))
            pose = compute_drops(body, rules, starts).pose
            block = (start + np.arange(len(pose))) // spec.block
            settled = pose >= 0
            np.add.at(counts[:, k], (pose[settled], block[settled]), 1)
    return counts
