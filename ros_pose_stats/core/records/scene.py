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

"""The scene that a part is dropped into."""

import hashlib
import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass, fields
from numbers import Integral, Real
from typing import Any, NamedTuple

from ...base.errors import RequestError
from ...base.text import length_in_words, listed
from .notes import Note, note

GRAVITY = 9.80665
DEFAULT_RESTITUTION = 0.5
DEFAULT_CLUSTER_TOLERANCE = 0.0025
DEFAULT_ROUND_SIDES = 192
"""Sides a turn of the polygons that stand for circles: they roll about as far as real
parts."""

FEWEST_ROUND_SIDES = 16
MOST_ROUND_SIDES = 4096
DEFAULT_DROP_RADII = 20.0
LOW_DROP_RADII = 5.0

HIGHEST_DROP = 2.0
HIGHEST_KICK = 0.5
"""Metres; no feeder drops or kicks a part higher, unless the part itself is as
large."""

HIGHEST_RADII = 1000.0
LARGE_RADII = 20.0
"""Radii up to which no part goes however low, and those that a large part may go."""

DEFAULT_DROPS = 10_000
DEFAULT_SEED = 1
"""Of the default answer, for any part: copies of one in another unit, frame or mass
have the same drops."""

DEFAULT_PLATE_ERROR = 0.05  # of a plate that nobody has counted on


NUMBERING_RULES = 1
"""Version of the rules that number poses: one more where a change of them lets an index
of any part stand for another pose."""


class Numbering(NamedTuple):
    """What numbers a part's poses: an index is one pose where it and digest agree."""

    # share of the centre of mass's height; NaN where it is not known
    cluster_tolerance: float
    round_sides: int  # 0: round surfaces as the file has them

    def __str__(self) -> str:
        """For people."""
        tolerance = self.cluster_tolerance
        digits = "unknown" if math.isnan(tolerance) else f"{tolerance:.12g}"
        return f"cluster_tolerance {digits} and round_sides {self.round_sides}"

    def code(self, digest: str) -> int:
        """64 bits that stand for it, a part's digest and the rules; 0 for none.

        The first eight bytes, little-endian, of the SHA-256 of the digest's characters,
        the tolerance as float64, the sides and the rules as uint32, little-endian all.
        """
        values = struct.pack("<dII", *self, NUMBERING_RULES)
        return int.from_bytes(
            hashlib.sha256(digest.encode() + values).digest()[:8], "little"
        )

    def agrees(self, other: "Numbering") -> bool:
        """Whether both are known and equal."""
        return self == other and not math.isnan(self.cluster_tolerance)


def numbering_of(message: Any) -> Numbering:
    """How a message numbers poses, the tolerance to 12 digits.

    Older nodes left round surfaces as the mesh has them.
    """
    tolerance = float(f"{float(getattr(message, 'cluster_tolerance', math.nan)):.12g}")
    # One object for all that are not known: a NaN as a key equals itself alone.
    return Numbering(
        tolerance if math.isfinite(tolerance) else math.nan,
        int(getattr(message, "round_sides", 0)),
    )


@dataclass(frozen=True)
class DropScene:
    """Restitution and drop height, and what of a part counts as a pose and as round.

    Attributes
    ----------
    restitution : float
        Coefficient of restitution, 0 <= restitution < 1.
    drop_height : float or None
        Height of the centre of mass above the plate at release, metres; None stands for
        20 part radii, as in the paper (section 3.B).
    cluster_tolerance : float
        Least rise of the centre of mass out of a pose, as a share of its height there;
        0 keeps every stable face.
    round_sides : int
        Sides a turn of the polygons that round surfaces are taken as; 0 takes the file
        as it is.

    Raises
    ------
    RequestError
        If a value is out of its range.
    """

    restitution: float = DEFAULT_RESTITUTION
    drop_height: float | None = None
    cluster_tolerance: float = DEFAULT_CLUSTER_TOLERANCE
    round_sides: int = DEFAULT_ROUND_SIDES

    def __post_init__(self) -> None:
        for name in ("restitution", "drop_height", "cluster_tolerance"):
            if name != "drop_height" or self.drop_height is not None:
                object.__setattr__(self, name, real_number(name, getattr(self, name)))
        if not 0.0 <= self.restitution < 1.0:
            raise RequestError(
                "a coefficient of restitution from 0 to below 1",
                f"{self.restitution}",
                "0.5 is a hard plate",
            )
        if self.drop_height is not None and not 0.0 < self.drop_height < math.inf:
            raise RequestError(
                "a drop height above 0 m",
                f"{self.drop_height} m",
                "leave it out for 20 part radii",
            )
        if not 0.0 <= self.cluster_tolerance < 1.0:
            raise RequestError(
                "a cluster tolerance from 0 to below 1",
                f"{self.cluster_tolerance}",
                "0.0025 of the height is a tilt of 4 degrees",
            )
        sides = self.round_sides
        if not is_whole_number(sides) or (
            sides and not FEWEST_ROUND_SIDES <= sides <= MOST_ROUND_SIDES
        ):
            raise RequestError(
                f"round_sides of 0, or {FEWEST_ROUND_SIDES} to {MOST_ROUND_SIDES}",
                f"{sides!r}",
                "0 takes round surfaces as the file has them",
            )

    @property
    def numbering(self) -> Numbering:
        """What numbers the poses; the rest of the scene has no say in that."""
        return Numbering(self.cluster_tolerance, self.round_sides)

    def release_height(self, radius: float) -> float:
        """Height of the centre of mass at release, metres, for a radius in metres."""
        return (
            DEFAULT_DROP_RADII * radius
            if self.drop_height is None
            else self.drop_height
        )


SCENE_FIELDS = tuple(field.name for field in fields(DropScene))
"""Names of the scene's values: keywords, keys of JSON, columns."""


def is_whole_number(value: Any) -> bool:
    """Whether a value is an integer of Python or NumPy, and no truth value."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def real_number(name: str, value: Any) -> float:
    """Read a number of a request as a float."""
    try:
        if not isinstance(value, bool) and isinstance(value, Real):
            return float(value) + 0.0  # -0 is 0
    except OverflowError:
        pass
    raise RequestError(f"a number for {name}", f"{value!r}", "give a float")


def height_warnings(
    name: str, height: float | None, radius: float, highest: float
) -> list[Note]:
    """One where no feeder has such a height, metres, for a part of this radius, metres.

    `name`: what kind of height; `highest`: that a feeder has, metres.
    """
    if height is None or height <= min(
        max(highest, LARGE_RADII * radius), HIGHEST_RADII * radius
    ):
        return []
    return [
        note(
            "HEIGHT_SUSPECT",
            f"a {name} height of {height:g} m, which no feeder has; heights are in "
            "metres whatever the unit of the mesh, so 200 mm are 0.2.",
        )
    ]


def describe_scene(
    restitution: float | Sequence[float], drop_height: float | None
) -> str:
    """The scene in one sentence: how high, onto what, how bouncy.

    `restitution`: several where each was dropped with; `drop_height`: None for the
    default; NaN where the method ignores both.
    """
    if drop_height is not None and math.isnan(drop_height):
        return "released at any height above a frictionless plate, at any restitution"
    height = (
        f"{DEFAULT_DROP_RADII:g} part radii"
        if drop_height is None
        else length_in_words(drop_height)
    )
    values = [restitution] if isinstance(restitution, (int, float)) else restitution
    return (
        f"released {height} above a frictionless plate, restitution "
        f"{listed([f'{value:g}' for value in values])}"
    )
