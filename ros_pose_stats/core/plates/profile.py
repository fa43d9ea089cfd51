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

"""What is known of a plate, and the file of plates (YAML) that keeps it."""

import errno
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from ...base import errors, files, version
from ..records import DropScene
from ..records.plain_values import plain_value
from .fit import AS_DEFAULT, UNKNOWN_SIDES, PlateFit

HEAD = "plates"
MOST_PLATES = 256
MOST_BYTES = 2**18  # of a file of plates: reading takes a second for so many
MOST_VALUES = 50_000  # in a file of plates, each as often as aliases repeat it
LONGEST_NAME = 100


class LeftOut(NamedTuple):
    """What a plate says of a part without that part's own counts."""

    cluster_tolerance: float
    round_sides: int  # by both of which the poses are numbered
    probability: tuple[float, ...]  # of its poses, by `index`


@dataclass(frozen=True)
class PlateProfile:
    """The scene that stands for a plate, and how far to trust it.

    Raises RequestError if a value is out of its range.
    """

    name: str
    # Each of the first two, and the sides, with the bounds of its 90 % interval.
    restitution: float  # effective
    restitution_low: float
    restitution_high: float
    drop_height: float  # effective, of the centre of mass, metres; -1: 20 part radii
    drop_height_low: float
    drop_height_high: float
    # expected root mean square error on a part that was not counted, as a fraction
    plate_error: float
    p_value: float = math.nan  # of the counts in this scene; NaN: nothing can test it
    parts: tuple[str, ...] = ()  # names of the parts that were counted
    counted: int = 0  # parts of all kinds together
    date: str = ""  # when it was fitted, ISO 8601, UTC
    version: str = ""  # of this package
    # effective sides a turn of round parts, and those that the counts do not exclude
    round_sides: int = UNKNOWN_SIDES[0]
    round_sides_low: int = UNKNOWN_SIDES[1]
    round_sides_high: int = UNKNOWN_SIDES[2]
    # probability that the default scene explains the counts best
    default_weight: float = math.nan
    # by digest of a counted part: what the others predict of it, so that its counts
    # count once
    left_out: Mapping[str, "LeftOut"] = field(default_factory=dict)

    def __post_init__(self) -> None:
        refuse_name(self.name)
        for sides in (self.round_sides, self.round_sides_low, self.round_sides_high):
            DropScene(
                self.restitution,
                None if self.drop_height == AS_DEFAULT else self.drop_height,
                round_sides=sides,
            )
        if not 0.0 <= self.plate_error <= 1.0:
            raise errors.RequestError(
                "a plate_error from 0 to 1", f"{self.plate_error}", "0.05 is 5 points"
            )

    @property
    def tells_round_sides(self) -> bool:
        """Whether the counts say anything of the sides."""
        sides = (self.round_sides, self.round_sides_low, self.round_sides_high)
        return sides != UNKNOWN_SIDES

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON and YAML can hold, without the name."""
        fields: dict[str, Any] = plain_value(vars(self))
        del fields["name"]
        return fields


def refuse_name(name: str) -> None:
    """Raise RequestError for a name that no plate can have."""
    if not 0 < len(name.strip()) <= LONGEST_NAME or not name.isprintable():
        raise errors.RequestError(
            f"a plate's name of 1 to {LONGEST_NAME} printable characters",
            f"{name!r}",
            "for instance glass",
        )


def profile_of(name: str, fit: PlateFit) -> PlateProfile:
    """The profile of a plate as it was fitted, with today's date."""
    restitution, restitution_low, restitution_high = fit.restitution
    drop_height, drop_height_low, drop_height_high = fit.drop_height
    round_sides, round_sides_low, round_sides_high = fit.round_sides
    return PlateProfile(
        name=name,
        restitution=restitution,
        restitution_low=restitution_low,
        restitution_high=restitution_high,
        drop_height=drop_height,
        drop_height_low=drop_height_low,
        drop_height_high=drop_height_high,
        plate_error=fit.plate_error,
        p_value=fit.p_value,
        parts=tuple(dict.fromkeys(part.part_id for part in fit.parts)),
        counted=fit.total,
        date=datetime.now(timezone.utc).isoformat(timespec="seconds"),
        version=version.VERSION,
        round_sides=round_sides,
        round_sides_low=round_sides_low,
        round_sides_high=round_sides_high,
        default_weight=fit.default_weight,
        left_out={
            part.part_digest: LeftOut(
                *part.numbering, tuple(part.left_out.round(9).tolist())
            )
            for part in fit.parts
        },
    )


def read_profiles(file: Path) -> dict[str, PlateProfile]:
    """All plates of a file, by name; raises RequestError if it cannot be read."""
    return {
        name: _read_profile(file, name, values)
        for name, values in _read_plates(file).items()
    }


def write_profile(file: Path, profile: PlateProfile) -> None:
    """Write a plate into a file; its other plates stay, comments do not.

    Raises RequestError if the file is there and is none of plates, or would become too
    large.
    """
    file = file.resolve()  # a link to the file stays a link
    files.make_directories(file.parent)
    with files.locked_directory(file.parent):
        plates = _read_plates(file) if file.exists() else {}
        plates.pop(profile.name, None)  # so that it comes last
        plates[profile.name] = profile.as_dict()
        data = yaml.safe_dump(
            {HEAD: plates}, sort_keys=False, allow_unicode=True, default_flow_style=None
        ).encode()
        _read_plates(file, data)  # whatever is written can be read
        files.replace_file(file, data)


def refuse_foreign(file: Path) -> None:
    """Raise RequestError where no plate can be written into a file."""
    if file.exists():
        _read_plates(file)


def _read_plates(file: Path, data: bytes | None = None) -> dict[str, Any]:
    """Plates of a file by name, as YAML has them; `data`: its new content."""
    try:
        if data is None:
            data = files.read_file(file, MOST_BYTES)
        if len(data) > MOST_BYTES:
            raise OSError(errno.EFBIG, f"of more than {MOST_BYTES} bytes")
        node = yaml.compose(data.decode("utf-8"), yaml.SafeLoader)
        if node is not None and _count_values(node, {}) > MOST_VALUES:
            raise ValueError(f"more than {MOST_VALUES} values")
        content = None if node is None else yaml.SafeLoader("").construct_document(node)
    except (
        OSError,
        UnicodeDecodeError,
        RecursionError,
        ValueError,
        yaml.YAMLError,
    ) as error:
        raise errors.RequestError(
            "a YAML file of plates",
            f"{file} ({errors.reason(error)})",
            "name another one with --plates",
        ) from error
    if content is None:  # an empty file
        return {}
    if (
        not isinstance(content, Mapping)
        or list(content) != [HEAD]
        or not isinstance(content[HEAD], Mapping | None)
    ):
        raise errors.RequestError(
            f"a YAML file with `{HEAD}:` and nothing else at its top",
            f"{file}",
            "name another one with --plates",
        )
    plates = content[HEAD] or {}
    if len(plates) > MOST_PLATES:
        raise errors.RequestError(
            f"a file of at most {MOST_PLATES} plates",
            f"{len(plates)} in {file}",
            "split it",
        )
    return {str(name): values for name, values in plates.items()}


def _count_values(node: Any, sizes: dict[int, int]) -> int:
    """Values that a node stands for, each as often as aliases of aliases repeat it."""
    if id(node) not in sizes:
        sizes[id(node)] = MOST_VALUES  # for a node that holds itself
        children = [] if isinstance(node, yaml.ScalarNode) else node.value
        if isinstance(node, yaml.MappingNode):
            children = [part for pair in children for part in pair]
        sizes[id(node)] = 1 + sum(_count_values(child, sizes) for child in children)
    return sizes[id(node)]


def _read_profile(file: Path, name: str, values: Any) -> PlateProfile:
    """One plate; numbers may be written as YAML takes for text (1e-3)."""
    expected = "restitution and drop_height of each plate"
    problem = f"{values!r}"
    try:
        if isinstance(values, Mapping):
            return PlateProfile(
                name,
                **{
                    key: read(values[key])
                    for key, read in READERS.items()
                    if key in REQUIRED or values.get(key) is not None
                },
            )
    except KeyError as error:
        expected = f"{error.args[0]} of each plate"
        problem = "none"
    except errors.RequestError as error:
        expected = error.expected
        problem = error.finding
    except (TypeError, ValueError, OverflowError, AttributeError) as error:
        expected = "numbers for each plate"
        problem = re.sub(r"^.*: ", "", str(error))
    raise errors.RequestError(
        expected, f"{problem} for {name} in {file}", "fit the plate again"
    )


def _read_integer(value: Any) -> int:
    number = int(value)
    if number != float(value):
        raise ValueError(f"round_sides of {value}")
    return number


def _read_left_out(
    cluster_tolerance: float, round_sides: int, probability: list[float]
) -> LeftOut:
    shares = tuple(map(float, probability))
    if not all(share >= 0.0 for share in shares) or not abs(sum(shares) - 1.0) < 1e-6:
        raise ValueError(f"probabilities {probability} of sum {sum(shares):g}")
    return LeftOut(float(cluster_tolerance), int(round_sides), shares)


REQUIRED = (
    "restitution",
    "restitution_low",
    "restitution_high",
    "drop_height",
    "drop_height_low",
    "drop_height_high",
    "plate_error",
)

READERS: dict[str, Callable[[Any], Any]] = {
    **dict.fromkeys((*REQUIRED, "p_value", "default_weight"), float),
    **dict.fromkeys(
        ("round_sides", "round_sides_low", "round_sides_high"), _read_integer
    ),
    "parts": lambda parts: tuple(map(str, parts)) if isinstance(parts, list) else (),
    "counted": int,
    "date": str,
    "version": str,
    "left_out": lambda parts: {
        str(digest): _read_left_out(**values) for digest, values in parts.items()
    },
}
"""Fields of a plate in a file; earlier versions did not write all."""
