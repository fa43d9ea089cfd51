"""What a comparison of variants found: shares, differences, verdicts, and what a feeder gets.

How the chances come about is in `verdicts`.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from ..records import DropScene, Part, PoseStatistics
from ..records.statistics import plain_number
from ..statistics.feeding import Bounded, Feeding
from ..statistics.paired_counts import PairedDifference
from ..version import VERSION
from .correspondence import Correspondence, MatchedPoses

SHOWN = "difference shown"
NONE_SHOWN = "none shown"

LEVEL = 0.05
"""Chance that a difference is shown between variants that do not differ."""

ONE_POINT = 0.01


class ShareDifference(NamedTuple):
    """One share in two variants."""

    first: Bounded  # the shares with their 90 % intervals
    second: Bounded
    difference: PairedDifference  # second less first, by the joint counts
    file_error: float  # standard deviation of what the facets of the files add to the difference
    plate_error: float  # the same of the plate
    # that the drops differ this much by chance alone, for all differences and looks together
    chance: float = 1.0
    # that they do by chance and by the files, together likewise, or that this difference is one of
    # the plate, whichever is the larger
    chance_on_plate: float = 1.0

    @property
    def model_error(self) -> float:
        """Standard deviation of what files and plate add to the difference."""
        return math.hypot(self.file_error, self.plate_error)

    @property
    def in_model(self) -> str:
        """Whether the drops show a difference in the model, beyond their chance."""
        return SHOWN if self.chance <= LEVEL else NONE_SHOWN

    @property
    def on_plate(self) -> str:
        """Whether a plate is expected to show it, beyond the error of model and plate."""
        return SHOWN if self.chance_on_plate <= LEVEL else NONE_SHOWN

    @property
    def half_width(self) -> float:
        """Half of the interval of the difference."""
        return 0.5 * (self.difference.high - self.difference.low)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "probability": [self.first.value, self.second.value],
            "probability_low": [self.first.low, self.second.low],
            "probability_high": [self.first.high, self.second.high],
            "difference": plain_number(self.difference.value),
            "difference_low": self.difference.low, "difference_high": self.difference.high,
            "standard_error": plain_number(self.difference.standard_error),
            "model_error": self.model_error,
            "p_value_in_model": self.chance, "p_value_on_plate": self.chance_on_plate,
            "in_model": self.in_model, "on_plate": self.on_plate}


class PoseComparison(NamedTuple):
    """A pose of the first variant beside that of another; see `MatchedPoses`."""

    poses: MatchedPoses
    share: ShareDifference


class FeederComparison(NamedTuple):
    """What a feeder gets that accepts the same poses of both."""

    poses: MatchedPoses  # those accepted in each
    lost: tuple[int, ...]  # wanted poses of the first variant that have no partner in the second
    share: ShareDifference  # of the accepted parts
    feeding: tuple[Feeding, Feeding]  # parts that lie wrong are dropped again


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
        own = [one.share for one in self.poses]
        return own if self.feeder is None else [*own, self.feeder.share]

    @property
    def in_model(self) -> str:
        """Whether any share differs in the model, by more than the chance of the drops."""
        return SHOWN if any(one.in_model == SHOWN for one in self.shares) else NONE_SHOWN

    @property
    def on_plate(self) -> str:
        """Whether any share is expected to differ on a plate."""
        return SHOWN if any(one.on_plate == SHOWN for one in self.shares) else NONE_SHOWN


@dataclass(frozen=True, eq=False)
class Comparison:
    """Variants of a part side by side."""

    parts: tuple[Part, ...]
    # of each variant, from the drops from which all came to rest
    found: tuple[PoseStatistics, ...]
    variants: tuple[VariantComparison, ...]  # the first variant beside each of the others
    scene: DropScene
    seed: int
    wanted: tuple[int, ...]
    plate_error: float
    seconds: float = math.nan

    @property
    def drops(self) -> int:
        """Of each variant."""
        return self.found[0].drops

    @property
    def is_settled(self) -> bool:
        """Whether every other variant differs from the first on a plate, for a feeder if asked."""
        asked = [one if one.feeder is None else one.feeder.share for one in self.variants]
        return all(one.on_plate == SHOWN for one in asked)

    @property
    def half_width(self) -> float:
        """Half of the widest interval of a difference."""
        return max(share.half_width for one in self.variants for share in one.shares)

    def as_dict(self) -> dict[str, Any]:
        """Plain values under the keys of the JSON contract."""
        first = self.found[0]
        return {
            "scene": first.scene, "restitution": first.restitution,
            "drop_height": first.drop_height, "cluster_tolerance": first.cluster_tolerance,
            "round_sides": first.round_sides, "seed": self.seed, "drops": self.drops,
            "unsettled": first.unsettled, "plate_error": self.plate_error,
            "seconds": plain_number(self.seconds), "version": VERSION,
            "wanted": list(self.wanted),
            "variants": [one.as_dict() for one in self.found],
            "comparisons": [_as_dict(one) for one in self.variants]}


def _as_dict(one: VariantComparison) -> dict[str, Any]:
    match = one.correspondence
    entry: dict[str, Any] = {
        "first": 0, "second": one.second,
        "matched_by": "orientation and footprint" if match.by_orientation
        else "footprint and height", "turned_degrees": round(math.degrees(match.angle), 3),
        "same_body": match.same_body,
        "in_model": one.in_model, "on_plate": one.on_plate,
        "poses": [{"first": list(pose.poses.first), "second": list(pose.poses.second),
                   **pose.share.as_dict()} for pose in one.poses]}
    if one.feeder is not None:
        entry["feeder"] = {
            "first": list(one.feeder.poses.first), "second": list(one.feeder.poses.second),
            "without_partner": list(one.feeder.lost), **one.feeder.share.as_dict(),
            "passes": [plain_number(way.passes.value) for way in one.feeder.feeding],
            "passes_low": [plain_number(way.passes.low) for way in one.feeder.feeding],
            "passes_high": [plain_number(way.passes.high) for way in one.feeder.feeding]}
    return entry
