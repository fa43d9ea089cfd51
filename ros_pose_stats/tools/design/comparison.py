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

"""What a comparison of variants found: shares, differences and verdicts.

How the chances come about is in `compare`.
"""

import math
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

from ...base.version import VERSION
from ...core.records import DropScene, Part, PoseStatistics
from ...core.records.plain_values import plain_value, with_units
from ...core.statistics import feeding
from . import paired_drops
from .correspondence import Correspondence, MatchedPoses

DIFFERENCE_SHOWN = "difference shown"
NO_DIFFERENCE = "none shown"

LEVEL = 0.05  # chance that a difference is shown between variants that do not differ


def verdict(chance: float) -> str:
    """Whether a difference is shown, from the chance of one so large without any."""
    return DIFFERENCE_SHOWN if chance <= LEVEL else NO_DIFFERENCE


class ShareDifference(NamedTuple):
    """One share in two variants."""

    first: feeding.Bounded  # the shares with their 90 % intervals
    second: feeding.Bounded
    difference: paired_drops.PairedDifference  # second less first, by the joint counts
    # standard deviation of what the facets of the files add to the difference
    file_error: float
    plate_error: float  # the same of the plate
    # that drops differ this much by chance alone, for all differences and looks
    # together
    chance: float = 1.0
    # that they do by chance and by the files, together likewise, or that this
    # difference is one of the plate, whichever is the larger
    chance_on_plate: float = 1.0

    @property
    def in_model(self) -> str:
        """Whether the drops show a difference in the model, beyond their chance."""
        return verdict(self.chance)

    @property
    def on_plate(self) -> str:
        """Whether a plate is expected to show it, beyond both errors."""
        return verdict(self.chance_on_plate)

    def as_dict(self) -> dict[str, Any]:
        """What JSON says of it."""
        return {
            "probability": [self.first.value, self.second.value],
            "probability_low": [self.first.low, self.second.low],
            "probability_high": [self.first.high, self.second.high],
            "difference": self.difference.value,
            "difference_low": self.difference.low,
            "difference_high": self.difference.high,
            "standard_error": self.difference.standard_error,
            "model_error": math.hypot(self.file_error, self.plate_error),
            "p_value_in_model": self.chance,
            "p_value_on_plate": self.chance_on_plate,
            "in_model": self.in_model,
            "on_plate": self.on_plate,
        }


class PoseComparison(NamedTuple):
    """A pose of the first variant beside that of another; see `MatchedPoses`."""

    poses: MatchedPoses
    share: ShareDifference


class FeederComparison(NamedTuple):
    """What a feeder gets that accepts the same poses of both."""

    poses: MatchedPoses  # those accepted in each
    share: ShareDifference  # of the accepted parts
    # wanted poses of the first variant that have no partner in the second
    lost: tuple[int, ...]

    @property
    def passes(self) -> tuple[feeding.Bounded, feeding.Bounded]:
        """Drops for each accepted part, where the others are dropped again."""
        first, second = self.share[:2]
        return feeding.passes_of(*first), feeding.passes_of(*second)


@dataclass(frozen=True, eq=False)
class VariantComparison:
    """The first variant beside another one."""

    second: int  # which variant, from 1 on
    correspondence: Correspondence
    # pairs first, the most probable ones first; then poses without a partner
    poses: tuple[PoseComparison, ...]
    feeder: FeederComparison | None

    @property
    def shares(self) -> list[ShareDifference]:
        """All that is tested."""
        shares = [pose.share for pose in self.poses]
        return shares if self.feeder is None else [*shares, self.feeder.share]

    @property
    def deciding(self) -> ShareDifference:
        """The share of accepted parts, else the largest difference shown."""
        if self.feeder is not None:
            return self.feeder.share
        return max(
            self.shares,
            key=lambda share: (
                share.on_plate == DIFFERENCE_SHOWN,
                share.in_model == DIFFERENCE_SHOWN,
                abs(share.difference.value),
            ),
        )

    @property
    def in_model(self) -> str:
        """Whether any share differs in the model, beyond the chance of the drops."""
        return verdict(min(share.chance for share in self.shares))

    @property
    def on_plate(self) -> str:
        """Whether any share is expected to differ on a plate."""
        return verdict(min(share.chance_on_plate for share in self.shares))

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        match = self.correspondence
        entry: dict[str, Any] = {
            "first": 0,
            "second": self.second,
            "matched_by": "orientation and footprint"
            if match.by_orientation
            else "footprint and height",
            "turned_degrees": round(math.degrees(match.angle), 3),
            "same_body": match.same_body,
            "in_model": self.in_model,
            "on_plate": self.on_plate,
            "poses": [
                {**pose.poses._asdict(), **pose.share.as_dict()} for pose in self.poses
            ],
        }
        if self.feeder is not None:
            entry["feeder"] = {
                **self.feeder.poses._asdict(),
                "without_partner": self.feeder.lost,
                **self.feeder.share.as_dict(),
                **{
                    f"passes{end}": [passes[column] for passes in self.feeder.passes]
                    for column, end in enumerate(("", "_low", "_high"))
                },
            }
        values: dict[str, Any] = plain_value(entry)
        return values


@dataclass(frozen=True, eq=False)
class Comparison:
    """Variants of a part side by side."""

    parts: tuple[Part, ...]
    # of each variant, from the drops from which all came to rest
    statistics: tuple[PoseStatistics, ...]
    # the first variant beside each of the others
    variants: tuple[VariantComparison, ...]
    scene: DropScene
    seed: int
    wanted: tuple[int, ...]
    plate_error: float
    seconds: float

    @property
    def drops(self) -> int:
        """Of each variant, behind the shares; as many before gave the verdicts."""
        return self.statistics[0].drops

    def as_dict(self) -> dict[str, Any]:
        """Plain values under the keys of the JSON contract."""
        first = self.statistics[0]
        return with_units(
            {
                "scene": first.scene,
                **asdict(self.scene),
                "seed": self.seed,
                "drops": self.drops,
                "unsettled": first.unsettled,
                "plate_error": self.plate_error,
                "seconds": self.seconds,
                "version": VERSION,
                "wanted": self.wanted,
                "variants": [answer.as_dict() for answer in self.statistics],
                "comparisons": [answer.as_dict() for answer in self.variants],
            }
        )
