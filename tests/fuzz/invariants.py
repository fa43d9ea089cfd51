"""What must hold for every part that is taken, checked on all its answers.

Each check yields what is wrong, a line each; nothing where all is well.
"""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np

from ros_pose_stats import (
    Part,
    PoseStatistics,
    estimate_all,
    resting_poses,
    simulate,
    splitting_graph,
)
from ros_pose_stats.records.scene import DEFAULT_CLUSTER_TOLERANCE
from ros_pose_stats.resting.equilibria import equilibria
from ros_pose_stats.resting.poses import RestingPoses
from ros_pose_stats.tolerances import SAME_HEIGHT, SAME_LEVEL

from .changes import Random
from .closeness import MARGINAL, marginal, roughness

TOLERANCES = (0.0, DEFAULT_CLUSTER_TOLERANCE)
DROPS = 3


def faults(part: Part, random: Random, thorough: bool = True) -> Iterator[str]:
    """Everything that is wrong with the answers about a part.

    Parameters
    ----------
    part : Part
    random : Generator
    thorough : bool
        Whether to ask at every tolerance rather than one of them.
    """
    yield from equilibria_faults(part)
    for tolerance in TOLERANCES if thorough else (float(random.choice(TOLERANCES)),):
        resting = resting_poses(part, tolerance)
        yield from pose_faults(resting)
        yield from graph_faults(resting)
        for found in estimate_all(part, cluster_tolerance=tolerance):
            yield from statistics_faults(found, len(resting.poses))
        yield from json_faults(found)
    yield from drop_faults(part, random)


def equilibria_faults(part: Part) -> Iterator[str]:
    """S - H + U = 2, and the faces' solid angles fill the sphere."""
    found = equilibria(part, 0)
    # A foot on a side is a stable face and a saddle at once, or neither.
    if found.poincare_hopf != 2 and marginal(part) > MARGINAL:
        yield f"S - H + U is {found.poincare_hopf}, and no foot is near a side"
    body = found.body
    # Corners off their merged faces move the sides, by that over the sine of the angle between
    # the faces, which are seen from their distance; never by more than a few tolerances.
    rough = roughness(body)
    off = 0.0 if rough < 1e-15 else min(10.0 * body.tolerance, 2000.0 * rough)
    allowed = 1e-9 + (off + 1e-14) / float(body.arrays.distance.min())
    missing = abs(float(body.arrays.angle.sum()) - 4.0 * np.pi)
    if not missing <= allowed:
        yield f"solid angles sum to 4 pi {missing:+.1e}, allowed {allowed:.1e}"


def pose_faults(resting: RestingPoses) -> Iterator[str]:
    """Poses by rising height, with finite lengths above 0, each stable face in one of them."""
    poses, radius = resting.poses, resting.body.radius
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
        if not np.isfinite(pose.position).all() or not np.isfinite(pose.orientation).all():
            yield "a pose without a place"


def graph_faults(resting: RestingPoses) -> Iterator[str]:
    """EAE and MEAE fall apart at the same saddles; shares and levels are what they must be."""
    slack = 2.0 * SAME_LEVEL * resting.body.radius
    trees = [list(splitting_graph(resting, function).walk()) for function in ("r", "R")]
    for r, R in zip(*trees, strict=True):
        same_saddle = r.level is None or np.array_equal(r.saddle, R.saddle)
        if r.poses != R.poses or r.level != R.level or not same_saddle:
            yield f"the graphs of r and R part at {r.poses}"
    for node in (node for tree in trees for node in tree if node.parts):
        if not abs(sum(node.transitions) - 1.0) < 1e-12 or min(node.transitions) < 0.0:
            yield f"transitions {node.transitions}"
        if any(part.level is not None and part.level > node.level + slack
               for part in node.parts):
            yield "a level rises on the way down"
        if not 0.0 <= sum(node.angles) <= 4.0 * np.pi * (1.0 + 1e-3):
            yield f"solid angles {node.angles}"


def statistics_faults(found: PoseStatistics, poses: int) -> Iterator[str]:
    """A distribution over all poses, most probable first."""
    values = np.array([pose.probability for pose in found.poses])
    if len(values) != poses or not np.isfinite(values).all() or values.min() < 0.0:
        yield f"{found.method}: probabilities {values.tolist()}"
    if not abs(values.sum() - 1.0) < 1e-9:
        yield f"{found.method}: probabilities sum to 1 {values.sum() - 1.0:+.1e}"
    if np.diff(values).max(initial=0.0) > 1e-9:
        yield f"{found.method}: not the most probable first"


def json_faults(found: PoseStatistics) -> Iterator[str]:
    """The answer as JSON has no NaN, no infinity, and reads back as it was."""
    try:
        text = json.dumps(found.as_dict(), allow_nan=False)
    except ValueError as error:
        yield f"{found.method}: {error}"
        return
    if json.loads(text) != found.as_dict():
        yield f"{found.method}: JSON reads back as something else"


def drop_faults(part: Part, random: Random) -> Iterator[str]:
    """Some drops come to rest in listed poses, and none is lost."""
    restitution = float(random.choice((0.0, 0.2, 0.5, 0.8)))
    found = simulate(part, DROPS, restitution, int(random.integers(2**32)), workers=1,
                     cluster_tolerance=0.0)
    counted = sum(pose.count for pose in found.poses)
    if counted + found.unsettled != DROPS or found.drops != DROPS:
        yield f"{found.drops} drops, {counted} settled and {found.unsettled} not, out of {DROPS}"
    if min(pose.count for pose in found.poses) < 0:
        yield "a count below 0"
    # Where none settles no probability is known.
    values = np.array([pose.probability for pose in found.poses])
    if counted and not abs(values.sum() - 1.0) < 1e-9:
        yield f"simulated probabilities sum to 1 {values.sum() - 1.0:+.1e}"
    yield from json_faults(found)
