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

"""Results of the comparison of the estimators with a dataset."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from lab.frame.documents import plain
from ros_pose_stats.core.records import Array

from ..dataset import DatasetSpec
from ..errors.partition import Accuracy, Noise

Range = tuple[int, int]


class Shapes(NamedTuple):
    """Ranges, as (least, most), of the bodies' properties."""

    values: int
    mean_poses: float
    poses: Range
    vertices: Range
    faces: Range
    redraws: int
    unsettled: int
    largest_probability: float


class Row(NamedTuple):
    """One estimator, or hybrid with the first drops, held against all the others.

    Attributes
    ----------
    name, title : str
    pooled : Accuracy
        Over all restitutions and drops.
    by_restitution : dict of float to Accuracy
    first : Accuracy or None
        Pooled, from the first drops alone, as in the paper; None for hybrid.
    """

    name: str
    title: str
    pooled: Accuracy
    by_restitution: dict[float, Accuracy]
    first: Accuracy | None = None


class Outlier(NamedTuple):
    """One of the largest deviations of the combined estimator, and the result of more
    drops.

    Attributes
    ----------
    body, pose : int
        Numbers in the dataset; the pose's within the body.
    restitution, estimate : float
    first : float
        Simulated probability after the first drops, by which it was found.
    again : tuple of (drops, probability)
        From fresh drops, independent of those and of each other.
    """

    body: int
    pose: int
    restitution: float
    estimate: float
    first: float
    again: tuple[tuple[int, float], ...]


@dataclass(frozen=True, eq=False)
class TableResults:
    """Everything in the table of one dataset.

    Attributes
    ----------
    spec : DatasetSpec
    shapes : Shapes
    rows : tuple of Row
        In the registry's order.
    first : int
        Number of the first drops, by which the largest deviations are found: 100 as in
        the paper, unless the blocks of the dataset are larger.
    noise : dict of float to Noise
        Of the paper's 100 drops, by restitution.
    pooled_noise : Noise
        The same over all restitutions.
    sensitivity : Accuracy or None
        Of the lowest restitution's probabilities against the highest's.
    combined : Row or None
        Of hybrid with the first drops, against all others; None where there are no
        others.
    outliers : tuple of Outlier
    estimates : dict of float to dict of str to (P,) array
        Behind the rows, by restitution.
    seconds : float
    """

    spec: DatasetSpec
    shapes: Shapes
    rows: tuple[Row, ...]
    first: int
    noise: dict[float, Noise]
    pooled_noise: Noise
    sensitivity: Accuracy | None
    combined: Row | None
    outliers: tuple[Outlier, ...]
    estimates: dict[float, dict[str, Array]]
    seconds: float

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON, the estimates left out."""
        return {
            "scene": self.spec.scene,
            "spec": self.spec.as_dict(),
            "shapes": plain(self.shapes),
            "estimators": [_row(row) for row in self.rows],
            "first_drops": self.first,
            "combined": self.combined
            and {
                "title": self.combined.title,
                "pooled": plain(self.combined.pooled),
                "by_restitution": plain(self.combined.by_restitution),
            },
            "noise_of_100": plain(self.noise),
            "pooled_noise_of_100": plain(self.pooled_noise),
            "sensitivity": plain(self.sensitivity),
            "outliers": plain(self.outliers),
            "seconds": self.seconds,
        }


def _row(row: Row) -> dict[str, Any]:
    return {
        "name": row.name,
        "pooled": plain(row.pooled),
        "pooled_of_first": plain(row.first),
        "by_restitution": plain(row.by_restitution),
    }
