"""Stable poses of a part on a plate, and the probabilities of coming to rest in each.

The names below are loaded when they are first used, so that importing the package, or a
command that needs only some of them, costs little.

Which room holds what, in the order in which an answer comes about:

- `mesh` makes a part of a file or of arrays; `records` are what travels between the rooms
- `resting` finds equilibria and stable poses; `estimators` give them probabilities without drops
- `simulation` drops the part, by `kernels.drops` (`detect`, `evolve`, `resolve` an impact)
- `statistics` says how sure counts are; `planning` chooses between estimates and drops
- `plates` and `design` fit a real plate and compare variants of a part; `catalogue` takes many
- `recording` writes and reads bags; `report` and `plots` draw
- `ros` is the node (`node` wires it; `parts` answers meshes, `jobs` drops, `services` requests,
  `state` keeps all of it); `commands` and `cli` are the command line
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from . import version

__version__ = version.VERSION

if TYPE_CHECKING:
    from .design.compare import compare
    from .design.sensitivity import sensitivity
    from .design.suggest import suggest
    from .errors import PoseStatsError
    from .estimators.estimate import estimate_all
    from .mesh.parts import load_part, part_from_mesh, shift_center
    from .planning.auto import auto, estimate
    from .planning.hybrid import hybrid
    from .recording.analysis.comparisons import analyse_bags
    from .records.drops import DropEvent, DropProgress, FlipStatistics, Trajectory
    from .records.part import Part
    from .records.scene import DropScene
    from .records.statistics import PoseStatistics, StablePose
    from .resting.observed_orientations import classify_orientations
    from .resting.outlines import outline_at
    from .resting.poses import resting_poses
    from .resting.splitting_graph import splitting_graph
    from .simulation.flips import simulate_flips
    from .simulation.record_drop import record_drop
    from .simulation.simulate import simulate
    from .statistics.counted_flips import learn_flips
    from .statistics.feeding_plan import FeederCell, FeedingPlan, plan_feeding

_HOMES = {
    "DropEvent": "records",
    "DropProgress": "records",
    "DropScene": "records",
    "FeederCell": "statistics.feeding_plan",
    "FeedingPlan": "statistics.feeding_plan",
    "FlipStatistics": "records",
    "Part": "records",
    "PoseStatistics": "records",
    "PoseStatsError": "errors",
    "StablePose": "records",
    "Trajectory": "records",
    "analyse_bags": "recording.analysis.comparisons",
    "auto": "planning.auto",
    "classify_orientations": "resting.observed_orientations",
    "compare": "design.compare",
    "estimate": "planning.auto",
    "estimate_all": "estimators",
    "hybrid": "planning.hybrid",
    "learn_flips": "statistics.counted_flips",
    "load_part": "mesh.parts",
    "outline_at": "resting.outlines",
    "part_from_mesh": "mesh.parts",
    "plan_feeding": "statistics.feeding_plan",
    "record_drop": "simulation.record_drop",
    "resting_poses": "resting.poses",
    "sensitivity": "design.sensitivity",
    "shift_center": "mesh.parts",
    "simulate": "simulation.simulate",
    "simulate_flips": "simulation.flips",
    "splitting_graph": "resting.splitting_graph",
    "suggest": "design.suggest",
}

__all__ = ["DropEvent", "DropProgress", "DropScene", "FeederCell", "FeedingPlan",
           "FlipStatistics", "Part", "PoseStatistics", "PoseStatsError", "StablePose",
           "Trajectory", "__version__", "analyse_bags", "auto", "classify_orientations",
           "compare", "estimate", "estimate_all", "hybrid", "learn_flips", "load_part",
           "outline_at", "part_from_mesh", "plan_feeding", "record_drop", "resting_poses",
           "sensitivity", "shift_center", "simulate", "simulate_flips", "splitting_graph",
           "suggest"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value
