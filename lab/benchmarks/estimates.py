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

"""Times of all estimates from the mesh arrays, and of estimates of paper-size
polyhedra.
"""

from collections.abc import Sequence

import trimesh
from scipy.spatial import ConvexHull
from trimesh.poses import compute_stable_poses

from lab.bodies.curved import Body
from lab.frame.results import Row, Section, Target
from lab.frame.timing import Contender, Pace, Timings, race
from ros_pose_stats import (
    Part,
    PoseStatistics,
    estimate,
    estimate_all,
    part_from_mesh,
    resting_poses,
)
from ros_pose_stats.core.kernels.levels.equilibria import find_equilibria
from ros_pose_stats.core.kernels.levels.splits import split_probabilities
from ros_pose_stats.core.records.scene import DEFAULT_CLUSTER_TOLERANCE
from ros_pose_stats.core.resting.convex_body import body_of

TOLERANCES = (0.0, DEFAULT_CLUSTER_TOLERANCE)
HULLS_FROM = 2000
"""Vertices from which on times are compared with scipy's hull; below, fixed costs
dominate.
"""
FEW_POSES = 20
MOST_HULLS = 5.0
SMALL = 10
OF_TRIMESH = 0.7
"""Vertices up to which all estimators take at most that share of trimesh's time."""
NEAR_SPHERE_SECONDS = 1.0

TIMED = (
    "`all`: `part_from_mesh` (checks, welding, winding, mass properties, hull) and "
    "`estimate_all` on a new part each time, so nothing is remembered. `hull`: "
    "`scipy.spatial.ConvexHull` of the same vertices and nothing else. `trimesh`: "
    "`trimesh.poses.compute_stable_poses(mesh, n_samples=1)` on a new `Trimesh` of the "
    "same arrays, whose construction is not timed. `stable` counts stable faces, "
    "`poses` what they merge into at the row's cluster tolerance. Ratios are medians "
    "of the ratios round by round; a contender stops after some seconds, so trimesh "
    "has one round on the largest sphere. The garbage collector is off but for "
    "trimesh, whose copies would fill the memory."
)


def all_estimators(
    bodies: Sequence[Body],
    pace: Pace,
    name: str = "all_estimators",
    title: str = "All estimators from the mesh",
    seconds: float | None = None,
) -> Section:
    """Table with rows for each body at both cluster tolerances; the targets are
    trimesh, and a number of seconds.
    """
    rows = [row for body in bodies for row in _rows(body, pace, seconds)]
    return Section(name, title, TIMED, tuple(rows))


def answers(body: Body, tolerance: float) -> tuple[Part, list[PoseStatistics]]:
    """Part and the answers of all estimators, from the mesh arrays."""
    part = part_from_mesh(body.vertices, body.triangles, unit="mm")
    return part, estimate_all(part, cluster_tolerance=tolerance, round_sides=0)


def _rows(body: Body, pace: Pace, seconds: float | None) -> list[Row]:
    def mesh() -> trimesh.Trimesh:
        return trimesh.Trimesh(body.vertices, body.triangles, process=False)

    timings = race(
        [
            *(
                Contender(f"{tolerance:g}", lambda _, t=tolerance: answers(body, t))
                for tolerance in TOLERANCES
            ),
            Contender("hull", lambda _: ConvexHull(body.vertices)),
            Contender(
                "trimesh",
                lambda mesh_object: compute_stable_poses(mesh_object, n_samples=1),
                mesh,
                collected=True,
            ),
        ],
        pace,
    )
    part = part_from_mesh(body.vertices, body.triangles, unit="mm")
    return [_row(body, part, tolerance, timings, seconds) for tolerance in TOLERANCES]


def _row(
    body: Body, part: Part, tolerance: float, timings: Timings, seconds: float | None
) -> Row:
    contender = f"{tolerance:g}"
    resting = resting_poses(part, tolerance, round_sides=0)
    stable = len(resting.equilibria.order)
    hulls = timings.ratio(contender, "hull")
    trimeshes = timings.ratio(contender, "trimesh")
    most_of_trimesh = OF_TRIMESH if len(body.vertices) <= SMALL else 1.0
    targets = [Target("all / trimesh", trimeshes, most_of_trimesh)]
    if stable <= FEW_POSES and len(body.vertices) >= HULLS_FROM:
        targets.append(Target("all / hull", hulls, MOST_HULLS))
    if seconds is not None:
        targets.append(Target("all, s", timings.median(contender), seconds))
    return Row(
        f"{body.name}, {len(body.vertices)} vertices, tolerance {contender}",
        {
            "stable": stable,
            "poses": len(resting.poses),
            "all, ms": timings.milliseconds(contender),
            "hull, ms": timings.milliseconds("hull"),
            "trimesh, ms": timings.milliseconds("trimesh"),
            "all / hull": hulls,
            "trimesh / all": timings.ratio("trimesh", contender),
        },
        tuple(targets),
    )


KERNEL_MILLISECONDS = 0.1
ESTIMATE_MILLISECONDS = 0.5
SPLIT_MILLISECONDS = 1.0
TOLERANCE = 0.0

PAPER_TIMED = (
    "`splits`: the kernel `split_probabilities` alone, on the arrays of body and merge "
    "tree. `equilibria`: the kernel `find_equilibria` that makes the tree. `estimate`: "
    "`estimate(part, 'meae')` with the convex body known and nothing else, so "
    "equilibria, poses, symmetry groups, splits and records are all in it. `again`: "
    "the same with the poses known too and only the split probabilities forgotten. "
    "`split`: `estimate(part, 'split')` with the convex body known and nothing else. "
    "All of them tell their expected errors, for which EAE, MEAE and QSE are compared. "
    "`hull`: `scipy.spatial.ConvexHull`, for scale. Cluster tolerance 0."
)


def paper_size(bodies: Sequence[Body], pace: Pace) -> Section:
    """A row for each body."""
    return Section(
        "paper_size",
        "MEAE and split of a paper-size polyhedron, the body ready",
        PAPER_TIMED,
        tuple(_paper_row(body, pace) for body in bodies),
    )


def _paper_row(body: Body, pace: Pace) -> Row:
    known_part = part_from_mesh(body.vertices, body.triangles)
    resting = resting_poses(known_part, TOLERANCE, round_sides=0)
    points = resting.body.points
    arrays = resting.body.arrays
    tree = resting.equilibria.arrays.tree
    splits = resting.clusters.split

    def with_body() -> Part:
        part = part_from_mesh(body.vertices, body.triangles)
        body_of(part, 0)
        return part

    def without_splits() -> Part:
        vars(resting).pop("passage_r", None)
        return known_part

    def meae(part: Part) -> object:
        return estimate(part, "meae", cluster_tolerance=TOLERANCE, round_sides=0)

    timings = race(
        [
            Contender(
                "splits", lambda _: split_probabilities(arrays, tree, splits, False)
            ),
            Contender("equilibria", lambda _: find_equilibria(points, arrays)),
            Contender("estimate", meae, with_body),
            Contender("again", meae, without_splits),
            Contender(
                "split",
                lambda part: estimate(
                    part, "split", cluster_tolerance=TOLERANCE, round_sides=0
                ),
                with_body,
            ),
            Contender("hull", lambda _: ConvexHull(body.vertices)),
        ],
        pace,
    )
    took = {name: timings.milliseconds(name) for name in timings.seconds}
    return Row(
        f"{body.name}, {len(body.vertices)} vertices",
        {
            "poses": len(resting.poses),
            **{f"{name}, ms": value for name, value in took.items()},
            "estimate / hull": timings.ratio("estimate", "hull"),
        },
        (
            Target("splits, ms", took["splits"], KERNEL_MILLISECONDS),
            Target(
                "splits + equilibria, ms",
                took["splits"] + took["equilibria"],
                KERNEL_MILLISECONDS,
            ),
            Target("estimate, ms", took["estimate"], ESTIMATE_MILLISECONDS),
            Target("again, ms", took["again"], ESTIMATE_MILLISECONDS),
            Target("split, ms", took["split"], SPLIT_MILLISECONDS),
        ),
    )
