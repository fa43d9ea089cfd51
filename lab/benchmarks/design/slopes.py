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

"""Estimated against dropped changes of the wanted share, one feature at a time."""

import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ros_pose_stats.base.errors import MeshError
from ros_pose_stats.core.records import Index
from ros_pose_stats.tools.design.changes import ChangedPart
from ros_pose_stats.tools.design.sensitivity import STEP, effect_error

from .cases import Case

CHOSEN = (("centre", 1), ("stretch", 1), ("face", 2))
"""Features of each kind that are drawn from those of a part."""

MOST_DROPS = 3000
FEWEST_DROPS = 200
SECONDS = 5.0
WORKERS = 2
"""Drops of each of two variants, the time that those of one part may take together, and
threads.
"""


class Slope(NamedTuple):
    """A change by one step, a twentieth of the radius, of one feature; shares as
    fractions.

    `estimated` and `measured` have standard errors; the change is half of that between
    a step to one side and one to the other.
    """

    family: str
    number: int
    kind: str
    estimated: float
    error: float
    measured: float
    measured_error: float
    drops: int


def measure_slopes(case: Case) -> list[Slope]:
    """Measure some features of a part, drawn at random."""
    space = case.space
    model = case.model
    features = []
    for kind, count in CHOSEN:
        candidates = np.flatnonzero(
            [feature.kind == kind for feature in space.features]
        )
        features += case.draw.choice(
            candidates, min(count, len(candidates)), replace=False
        ).tolist()
    base = space.change_feature(0, 0.0)
    share = model.estimate(base)
    drops = _affordable(case, base, 2 * len(features))
    slopes = []
    for number in features:
        feature = space.features[number]
        unit = STEP * (space.body.radius if feature.is_length else 1.0)
        try:
            pair = [space.change_feature(number, side) for side in (-unit, unit)]
        except MeshError:  # a step that leaves no body is no case
            continue
        opposite, change = (model.estimate(variant) - share for variant in pair)
        slope = 0.5 * (change - opposite)
        measured = model.goal.gain(*drop_classes(case, pair, drops, case.number))
        slopes.append(
            Slope(
                case.family,
                case.number,
                feature.kind,
                slope,
                effect_error(slope, 0.5 * abs(change + opposite)),
                0.5 * measured.value,
                0.5 * max(measured.standard_error, 1.0 / measured.trials),
                measured.trials,
            )
        )
    return slopes


def drop_classes(
    case: Case, parts: Sequence[ChangedPart], drops: int, seed: int
) -> Index:
    """Classes of poses (V, n) in which changed parts come to rest."""
    pairs = case.model.pair_drops(parts, seed, WORKERS, lambda: False)
    pairs.drop_until(drops, lambda drops_done: None)
    return case.model.classes(pairs, parts)


def _affordable(case: Case, base: ChangedPart, variants: int) -> int:
    """Drops of each variant that fit in the time; rolling parts are slow."""
    trial = 50
    begin = time.process_time()
    drop_classes(case, [base], trial, 0)
    seconds = (time.process_time() - begin) / trial
    return int(min(MOST_DROPS, max(FEWEST_DROPS, SECONDS / (variants * seconds))))
