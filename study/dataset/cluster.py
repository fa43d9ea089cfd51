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

"""Makes the pieces of a dataset on a dask.distributed cluster."""

from collections.abc import Callable, Generator, Sequence

from ros_pose_stats.tools.batch.cluster import (
    WORKER_SECONDS,
    ClusterWork,
    work_on_cluster,
)

from .archive import Arrays
from .making import Made, Maker, Piece, make_chunk
from .spec import DatasetSpec

IN_HAND = 2000
"""Pieces handed out at a time."""


def on_cluster(address: str, worker_seconds: float = WORKER_SECONDS) -> Maker:
    """Pieces made by the workers of a scheduler; lost workers' pieces are made by
    others.

    Parameters
    ----------
    address : str
        Of the scheduler, such as `tcp://10.0.0.1:8786`. It and the workers need this
        package in this version; on machines of one kind they give the same numbers as
        this one.
    worker_seconds : float
        How long to wait while there is no worker at all.

    Raises
    ------
    BatchError
        While running: if the scheduler cannot be reached or goes away, no worker comes,
        or a piece fails.
    """

    def make(
        spec: DatasetSpec, pieces: Sequence[Piece], should_stop: Callable[[], bool]
    ) -> Generator[Made, None, None]:
        work: ClusterWork[Piece, Arrays] = ClusterWork(
            make_chunk, lambda piece: (spec, *piece), lambda _: IN_HAND
        )
        yield from work_on_cluster(address, work, pieces, should_stop, worker_seconds)

    return make
