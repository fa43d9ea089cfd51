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

"""Records as plain values, as JSON takes them, and the units of their keys."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .part import Array

UNITS = {
    "radius": "m",
    "unit": "m",
    "drop_height": "m",
    "drop_height_low": "m",
    "drop_height_high": "m",
    "kick_height": "m",
    "seconds": "s",
    "max_seconds": "s",
    "height": "m",
    "top": "m",
    "barrier": "m",
    "position": "m",
    "margin": "rad",
    "spread": "rad",
    "per_minute": "1/min",
    "step": "m",
    "place": "m",
    "size": "m^2",
    "within": "m",
    "outline": "m",
    "center_shift": "m",
    "center_of_mass": "m",
}
"""By key, of what is no plain number, share or unit vector and has no unit in its key.

A `step` that has a `unit` beside it is in that one, and text has no unit.
"""

ROUNDING = 1e-14
"""Components this much smaller than the largest are rounding."""


def with_units(
    record: dict[str, Any], units: Mapping[str, str] = UNITS
) -> dict[str, Any]:
    """A record as JSON takes it, and under `units` the units of its keys."""
    values: dict[str, Any] = plain_value(record)
    keys = set(_keys(values))
    values["units"] = {key: unit for key, unit in units.items() if key in keys}
    return values


def plain_value(value: Any) -> Any:
    """Numbers, strings, lists and dicts of whatever this was.

    JSON has no NaN and no infinity: they are None. -0 is 0, and named tuples are dicts.
    """
    if hasattr(value, "_asdict"):
        return plain_value(value._asdict())
    if isinstance(value, dict):
        return {key: plain_value(member) for key, member in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return plain_value(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain_value(member) for member in value]
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None
    return str(value) if isinstance(value, Path) else value


def without_rounding(vector: Array, scale: float = 0.0) -> Array:
    """A vector with 0 for rounding beside its largest component, or a `scale`."""
    smallest = ROUNDING * max(scale, float(np.abs(vector).max()))
    return np.where(np.abs(vector) <= smallest, 0.0, vector)


def _keys(value: Any) -> Iterator[str]:
    """Keys of all dicts in a value that may have a unit.

    None of a text, as an effect's `unit`, nor a `step` that has its own beside it.
    """
    members = value
    if isinstance(value, dict):
        for key, member in value.items():
            if not isinstance(member, str) and (key != "step" or "unit" not in value):
                yield key
        members = value.values()
    for member in members:
        if isinstance(member, (dict, list)):
            yield from _keys(member)
