"""MEAE and split of polyhedra of the paper's size, the convex body ready."""

from __future__ import annotations

from collections.abc import Sequence

from scipy.spatial import ConvexHull

from ros_pose_stats import Part, estimate, part_from_mesh, resting_poses
from ros_pose_stats.kernels.body.equilibria import find_equilibria
from ros_pose_stats.kernels.levels.splits import split_probabilities
from ros_pose_stats.resting.convex_body import convex_body

from .bodies import Body
from .results import Row, Section, Target
from .timing import Contender, Pace, race

KERNEL_MILLISECONDS = 0.1
ESTIMATE_MILLISECONDS = 0.5
SPLIT_MILLISECONDS = 1.0
TOLERANCE = 0.0

TIMED = (
    "`splits`: the kernel `split_probabilities` alone, on the arrays of body and merge tree. "
    "`equilibria`: the kernel `find_equilibria` that makes the tree. `estimate`: "
    "`estimate(part, 'meae')` with the convex body known and nothing else, so equilibria, "
    "poses, symmetry groups, splits and records are all in it. `again`: the same with "
    "the poses known too and only the split probabilities forgotten. `split`: "
    "`estimate(part, 'split')` with the convex body known and nothing else. All of them tell "
    "their expected errors, for which EAE, MEAE and QSE are compared. `hull`: "
    "`scipy.spatial.ConvexHull`, for scale. Cluster tolerance 0.")


def paper_size(bodies: Sequence[Body], pace: Pace) -> Section:
    """A row for each body."""
    return Section("paper_size", "MEAE and split of a paper-size polyhedron, the body ready",
                   TIMED, tuple(_row(body, pace) for body in bodies))


def _row(body: Body, pace: Pace) -> Row:
    known = part_from_mesh(body.vertices, body.triangles)
    resting = resting_poses(known, TOLERANCE)
    points, arrays = resting.body.points, resting.body.arrays
    tree, wanted = resting.equilibria.arrays.tree, resting.clusters.split

    def with_body() -> Part:
        part = part_from_mesh(body.vertices, body.triangles)
        convex_body(part)
        return part

    def without_splits() -> Part:
        vars(resting).pop("passage_r", None)
        return known

    def meae(part: Part) -> object:
        return estimate(part, "meae", cluster_tolerance=TOLERANCE)

    timings = race([
        Contender("splits", lambda _: split_probabilities(arrays, tree, wanted, False)),
        Contender("equilibria", lambda _: find_equilibria(points, arrays)),
        Contender("estimate", meae, with_body),
        Contender("again", meae, without_splits),
        Contender("split", lambda part: estimate(part, "split", cluster_tolerance=TOLERANCE),
                  with_body),
        Contender("hull", lambda _: ConvexHull(body.vertices)),
    ], pace)
    took = {name: timings.milliseconds(name) for name in timings.seconds}
    return Row(f"{body.name}, {len(body.vertices)} vertices", {
        "poses": len(resting.poses),
        **{f"{name}, ms": value for name, value in took.items()},
        "estimate / hull": timings.ratio("estimate", "hull"),
    }, (
        Target("splits, ms", took["splits"], KERNEL_MILLISECONDS),
        Target("splits + equilibria, ms", took["splits"] + took["equilibria"],
               KERNEL_MILLISECONDS),
        Target("estimate, ms", took["estimate"], ESTIMATE_MILLISECONDS),
        Target("again, ms", took["again"], ESTIMATE_MILLISECONDS),
        Target("split, ms", took["split"], SPLIT_MILLISECONDS),
    ))
