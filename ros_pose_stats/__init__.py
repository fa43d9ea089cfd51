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

"""Stable poses of a part on a plate, and the probabilities of coming to rest in each.

The names below are loaded when they are first used, so that importing the package, or a
command that needs only some of them, costs little.

`core` computes: from a mesh (`mesh`) over stable poses (`resting`) to probabilities,
without drops (`estimators`), by drops (`simulation`) or by both (`planning`). `node` is
the ROS 2 node. `tools` are the command line, pages, pictures, variants of a part, and
the analysis of bags. All stand on `base`. docs/architecture.md draws the rooms.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .base import version

__version__ = version.VERSION

if TYPE_CHECKING:
    from .base.errors import PoseStatsError
    from .core.estimators.estimate import estimate_all
    from .core.mesh.parts import load_part, part_from_mesh, shift_center
    from .core.planning.auto import auto, estimate
    from .core.planning.feeder_cell import FeederCell
    from .core.planning.feeding_plan import FeedingPlan, plan_feeding
    from .core.planning.hybrid import hybrid
    from .core.planning.upright import upright
    from .core.records.drops import DropEvent, DropProgress, FlipStatistics, Trajectory
    from .core.records.part import Part
    from .core.records.poses import StablePose
    from .core.records.scene import DropScene
    from .core.records.statistics import PoseStatistics
    from .core.resting.observed_orientations import classify_orientations
    from .core.resting.outlines import outline_at
    from .core.resting.poses import resting_poses
    from .core.resting.silhouettes import find_lookalikes
    from .core.resting.splitting_graph import splitting_graph
    from .core.simulation.flips import simulate_flips
    from .core.simulation.record_drop import record_drop
    from .core.simulation.simulate import simulate
    from .core.statistics.feeding import learn_flips
    from .tools.bags.comparisons import analyse_bags
    from .tools.design.compare import compare
    from .tools.design.sensitivity import sensitivity
    from .tools.design.suggest import suggest

_HOMES = {
    name: home
    for home, names in (
        ("tools.design.compare", "compare"),
        ("tools.design.sensitivity", "sensitivity"),
        ("tools.design.suggest", "suggest"),
        ("base.errors", "PoseStatsError"),
        ("core.estimators", "estimate_all"),
        ("core.mesh.parts", "load_part part_from_mesh shift_center"),
        ("core.planning.auto", "auto estimate"),
        ("core.planning.feeder_cell", "FeederCell"),
        ("core.planning.feeding_plan", "FeedingPlan plan_feeding"),
        ("core.planning.hybrid", "hybrid"),
        ("core.planning.upright", "upright"),
        ("tools.bags.comparisons", "analyse_bags"),
        (
            "core.records",
            "DropEvent DropProgress DropScene FlipStatistics Part PoseStatistics "
            "StablePose Trajectory",
        ),
        ("core.resting.observed_orientations", "classify_orientations"),
        ("core.resting.outlines", "outline_at"),
        ("core.resting.poses", "resting_poses"),
        ("core.resting.silhouettes", "find_lookalikes"),
        ("core.resting.splitting_graph", "splitting_graph"),
        ("core.simulation.flips", "simulate_flips"),
        ("core.simulation.record_drop", "record_drop"),
        ("core.simulation.simulate", "simulate"),
        ("core.statistics.feeding", "learn_flips"),
    )
    for name in names.split()
}

__all__ = [
    "DropEvent",
    "DropProgress",
    "DropScene",
    "FeederCell",
    "FeedingPlan",
    "FlipStatistics",
    "Part",
    "PoseStatistics",
    "PoseStatsError",
    "StablePose",
    "Trajectory",
    "__version__",
    "analyse_bags",
    "auto",
    "classify_orientations",
    "compare",
    "estimate",
    "estimate_all",
    "find_lookalikes",
    "hybrid",
    "learn_flips",
    "load_part",
    "outline_at",
    "part_from_mesh",
    "plan_feeding",
    "record_drop",
    "resting_poses",
    "sensitivity",
    "shift_center",
    "simulate",
    "simulate_flips",
    "splitting_graph",
    "suggest",
    "upright",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value
