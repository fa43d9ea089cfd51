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

"""What must hold for every part that is taken, checked on all its answers.

Each check yields what is wrong, a line each; nothing where all is well. Equilibria and
faces are looked at through `resting_poses`.
"""

import json
from collections.abc import Iterator
from typing import Any

import numpy as np

from ros_pose_stats import (
    Part,
    PoseStatistics,
    estimate_all,
    resting_poses,
    simulate,
    splitting_graph,
)
from ros_pose_stats.core.tolerances import TIP_MARGIN

TOLERANCES = (0.0, 0.0025)
DROPS = 3

MARGINAL = 1e-8
"""A foot this close to a side or a corner, in radii, may be on it: ten times what
counts so.
"""

SAME_HEIGHT = 1e-6
SAME_LEVEL = 1e-10
"""Heights of poses and levels of saddles this close, in radii, may come in either
order.
"""


def faults(part: Part, seed: int, thorough: bool) -> Iterator[str]:
    """Everything that is wrong with the answers about a part, at one tolerance or at
    all.
    """
    yield from equilibria_faults(part)
    for tolerance in TOLERANCES if thorough else (TOLERANCES[seed % 2],):
        resting = resting_poses(part, tolerance)
        yield from pose_faults(resting)
        yield from graph_faults(resting)
        for answer in estimate_all(part, cluster_tolerance=tolerance):
            yield from statistics_faults(answer, len(resting.poses))
        yield from json_faults(answer)
    yield from drop_faults(part, seed)


def marginal(equilibria: Any) -> float:
    """Distance of the nearest foot from a side or corner, in radii.

    At 0 an equilibrium is about to vanish: a stable face and a saddle, or a saddle and
    an unstable corner.
    """
    arrays = equilibria.body.arrays
    return float(
        min(
            np.abs(lengths).min()
            for lengths in (arrays.inset, arrays.start, arrays.stop)
        )
    )


def roughness(body: Any) -> float:
    """How far hull points are off the nearest of the faces, and corners off their own,
    in radii.

    0 but for rounding, unless triangles were merged that are not quite coplanar.
    """
    arrays = body.arrays
    point_gap = (
        np.abs(body.points @ arrays.normal.T - arrays.distance).min(axis=1).max()
    )
    corners = np.einsum(
        "sx,sx->s", body.points[arrays.corner], arrays.normal[arrays.face]
    )
    return float(max(point_gap, np.abs(corners - arrays.distance[arrays.face]).max()))


def equilibria_faults(part: Part) -> Iterator[str]:
    """S - H + U = 2, and the faces' solid angles fill the sphere."""
    equilibria = resting_poses(part, 0.0, 0).equilibria
    # A foot on a side is a stable face and a saddle at once, or neither.
    arrays = equilibria.body.arrays
    side = np.arange(len(equilibria.body.arrays.twin))
    saddles = np.count_nonzero(
        (side < arrays.twin)
        & (
            np.minimum(
                np.minimum(arrays.start, arrays.stop),
                np.minimum(arrays.inset, arrays.inset[arrays.twin]),
            )
            > TIP_MARGIN
        )
    )
    poincare_hopf = len(equilibria.faces) - saddles + len(equilibria.peaks)
    if poincare_hopf != 2 and marginal(equilibria) > MARGINAL:
        yield f"S - H + U is {poincare_hopf}, and no foot is near a side"
    body = equilibria.body
    # Corners off their merged faces move the sides, by that over the sine of the angle
    # between the faces, which are seen from their distance; never by more than a few
    # tolerances.
    rough = roughness(body)
    corner_gap = 0.0 if rough < 1e-15 else min(10.0 * body.tolerance, 2000.0 * rough)
    allowed = 1e-9 + (corner_gap + 1e-14) / float(body.arrays.distance.min())
    missing = abs(float(body.arrays.angle.sum()) - 4.0 * np.pi)
    if not missing <= allowed:
        yield f"solid angles sum to 4 pi {missing:+.1e}, allowed {allowed:.1e}"


def pose_faults(resting: Any) -> Iterator[str]:
    """Poses by rising height, with finite lengths above 0, each stable face in one of
    them.
    """
    poses = resting.poses
    radius = resting.body.radius
    for name in ("height", "top", "margin", "barrier", "spread"):
        values = np.array([getattr(pose, name) for pose in poses])
        endless = name == "barrier" and len(poses) == 1
        if not ((values >= 0.0) & (np.isfinite(values) != endless)).all():
            yield f"{name} is {values.tolist()}"
    heights = np.array([pose.height for pose in poses])
    if np.diff(heights).min(initial=0.0) < -2.0 * SAME_HEIGHT * radius:
        yield f"heights {heights.tolist()} do not rise"
    if [pose.index for pose in poses] != list(range(len(poses))):
        yield "poses are not numbered from 0"
    members = sorted(member for pose in poses for member in pose.members)
    if members != list(range(len(resting.equilibria.faces))):
        yield "a stable face is in no pose, or in two"
    for pose in poses:
        if not abs(np.linalg.norm(pose.down) - 1.0) < 1e-12:
            yield f"down is {pose.down.tolist()}"
        if (
            not np.isfinite(pose.position).all()
            or not np.isfinite(pose.orientation).all()
        ):
            yield "a pose without a place"


def graph_faults(resting: Any) -> Iterator[str]:
    """EAE and MEAE fall apart at the same saddles; shares and levels are what they must
    be.
    """
    slack = 2.0 * SAME_LEVEL * resting.body.radius
    trees = [list(splitting_graph(resting, function).walk()) for function in ("r", "R")]
    for node_of_r, node_of_R in zip(*trees, strict=True):
        same_saddle = node_of_r.level is None or np.array_equal(
            node_of_r.saddle, node_of_R.saddle
        )
        if (
            node_of_r.poses != node_of_R.poses
            or node_of_r.level != node_of_R.level
            or not same_saddle
        ):
            yield f"the graphs of r and R part at {node_of_r.poses}"
    for node in (node for tree in trees for node in tree if node.parts):
        if not abs(sum(node.transitions) - 1.0) < 1e-12 or min(node.transitions) < 0.0:
            yield f"transitions {node.transitions}"
        if any(
            part.level is not None and part.level > node.level + slack
            for part in node.parts
        ):
            yield "a level rises on the way down"
        if not 0.0 <= sum(node.angles) <= 4.0 * np.pi * (1.0 + 1e-3):
            yield f"solid angles {node.angles}"


def statistics_faults(answer: PoseStatistics, poses: int) -> Iterator[str]:
    """A distribution over all poses, most probable first."""
    values = np.array([pose.probability for pose in answer.poses])
    if len(values) != poses or not np.isfinite(values).all() or values.min() < 0.0:
        yield f"{answer.method}: probabilities {values.tolist()}"
    if not abs(values.sum() - 1.0) < 1e-9:
        yield f"{answer.method}: probabilities sum to 1 {values.sum() - 1.0:+.1e}"
    if np.diff(values).max(initial=0.0) > 1e-9:
        yield f"{answer.method}: not the most probable first"


def json_faults(answer: PoseStatistics) -> Iterator[str]:
    """The answer as JSON has no NaN, no infinity, and reads back as it was."""
    try:
        text = json.dumps(answer.as_dict(), allow_nan=False)
    except ValueError as error:
        yield f"{answer.method}: {error}"
        return
    if json.loads(text) != answer.as_dict():
        yield f"{answer.method}: JSON reads back as something else"


def drop_faults(part: Part, seed: int) -> Iterator[str]:
    """Some drops come to rest in listed poses, and none is lost."""
    restitution = (0.0, 0.2, 0.5, 0.8)[seed // 2 % 4]
    answer = simulate(part, DROPS, restitution, seed, workers=1, cluster_tolerance=0.0)
    counted = sum(pose.count for pose in answer.poses)
    if counted + answer.unsettled != DROPS or answer.drops != DROPS:
        yield (
            f"{answer.drops} drops, {counted} settled and {answer.unsettled} not, out "
            f"of {DROPS}"
        )
    if min(pose.count for pose in answer.poses) < 0:
        yield "a count below 0"
    # Where none settles no probability is known.
    values = np.array([pose.probability for pose in answer.poses])
    if counted and not abs(values.sum() - 1.0) < 1e-9:
        yield f"simulated probabilities sum to 1 {values.sum() - 1.0:+.1e}"
    yield from json_faults(answer)
