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

"""Counted drops of the bodies that the split estimator is fitted to and judged by."""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ros_pose_stats.base.files import write_whole
from ros_pose_stats.core.records import Index

FILE = Path(__file__).resolve().parent / "samples.npz"

FIT_SEED = 11
JUDGE_SEED = 2
"""Seeds of the series of bodies for the fit, and of those for the judgement."""

USUAL = (0.2, 0.5, 0.8)
HEIGHT = 20.0
LOW = 2.0
"""Drop heights, in radii, at which all bodies are judged."""


class Sample(NamedTuple):
    """One body in one scene."""

    family: str
    seed: int  # of the body, as `family_part` takes it
    number: int
    restitution: float
    height: float  # radii
    unsettled: int  # drops that met the step cap
    count: Index  # (P,) drops that came to rest in each pose, by `index`


def write_samples(samples: Iterable[Sample], file: Path = FILE) -> None:
    """Write samples, whole or not at all."""
    rows = list(samples)
    names = sorted({row.family for row in rows})
    columns = {
        "names": np.array(names),
        "family": np.array([names.index(row.family) for row in rows], np.uint8),
        "seed": np.array([row.seed for row in rows], np.uint8),
        "number": np.array([row.number for row in rows], np.uint16),
        "restitution": np.array([row.restitution for row in rows]),
        "height": np.array([row.height for row in rows]),
        "unsettled": np.array([row.unsettled for row in rows], np.uint16),
        "poses": np.array([row.count.size for row in rows], np.uint16),
        "count": np.concatenate([row.count for row in rows]).astype(np.uint16),
    }
    # The array names are ours; none is that of an argument of savez.
    write_whole(
        file.parent, lambda folder: np.savez_compressed(folder / file.name, **columns)
    )  # type: ignore[arg-type]


def read_samples(file: Path = FILE) -> list[Sample]:
    """Read samples in the order of the file, where all scenes of a body follow each
    other.
    """
    with np.load(file) as archive:
        columns = {name: archive[name] for name in archive.files}
    counts = np.split(
        columns["count"].astype(np.int64), np.cumsum(columns["poses"])[:-1]
    )
    names = columns["names"].tolist()
    return [
        Sample(names[family], *row, count)
        for family, *row, count in zip(
            *(
                columns[name].tolist()
                for name in (
                    "family",
                    "seed",
                    "number",
                    "restitution",
                    "height",
                    "unsettled",
                )
            ),
            counts,
            strict=True,
        )
    ]
