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

"""Frozen records that travel between the rooms.

They are loaded when they are first used: the command line takes defaults from `scene`,
and must not load numpy for `--version` or `--help`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .drops import DropEvent, DropProgress, FlipStatistics, Trajectory
    from .notes import Note
    from .part import Array, Corners, Index, Mask, Part
    from .poses import RestingShape, StablePose
    from .scene import DropScene
    from .statistics import PoseStatistics

_HOMES = {
    "Array": "part",
    "Corners": "part",
    "DropEvent": "drops",
    "DropProgress": "drops",
    "DropScene": "scene",
    "FlipStatistics": "drops",
    "Index": "part",
    "Mask": "part",
    "Note": "notes",
    "Part": "part",
    "PoseStatistics": "statistics",
    "RestingShape": "poses",
    "StablePose": "poses",
    "Trajectory": "drops",
}

__all__ = [
    "Array",
    "Corners",
    "DropEvent",
    "DropProgress",
    "DropScene",
    "FlipStatistics",
    "Index",
    "Mask",
    "Note",
    "Part",
    "PoseStatistics",
    "RestingShape",
    "StablePose",
    "Trajectory",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value
