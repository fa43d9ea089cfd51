"""Errors of the split estimator on parts as a designer draws them, which no fit has seen."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ros_pose_stats import (
    DropScene,
    Part,
    load_part,
    part_from_mesh,
    resting_poses,
    simulate,
)
from ros_pose_stats.core.estimators import ESTIMATORS
from ros_pose_stats.core.estimators.expected import expected_error
from ros_pose_stats.core.shapes.demo_parts import DEMO_PARTS

from .samples import LOW, USUAL

Array = NDArray[np.float64]

DROPS = 4000
HEIGHTS = (20.0, LOW)
SEED = 17
MILLIMETRE = 1e-3


class PartScore(NamedTuple):
    """Errors on one part, in points, pooled over the restitutions, the drops' noise taken off.

    Attributes
    ----------
    part : str
    poses : int
    height : float
        Radii.
    split, combined, expected : float
        Root mean squares over the poses; the expected error of `split`.
    largest, combined_largest : float
        Largest deviation of a pose, noise included.
    """

    part: str
    poses: int
    height: float
    split: float
    combined: float
    expected: float
    largest: float
    combined_largest: float


def demo_parts() -> Iterator[tuple[str, Part]]:
    """Load the demo parts."""
    for name, make in DEMO_PARTS.items():
        vertices, triangles = make()
        yield (
            name,
            part_from_mesh(MILLIMETRE * np.asarray(vertices, dtype=float), triangles),
        )


def mesh_files(files: Sequence[Path]) -> Iterator[tuple[str, Part]]:
    """Load parts from files, in millimetres where the format has no unit."""
    for file in files:
        yield file.name, load_part(file, unit="mm")


def judge_parts(
    parts: Iterator[tuple[str, Part]], on_progress: Callable[[str], object]
) -> list[PartScore]:
    """Score each part, dropped from each height."""
    found = []
    for name, part in parts:
        on_progress(name)
        found += [_score(name, part, height) for height in HEIGHTS]
    return found


def _score(name: str, part: Part, height: float) -> PartScore:
    resting = resting_poses(part)
    squares: dict[str, list[float]] = {"split": [], "combined": []}
    largest: dict[str, float] = dict.fromkeys(squares, 0.0)
    expected = []
    for restitution in USUAL:
        scene = DropScene(restitution, height * resting.body.radius)
        counted = simulate(part, DROPS, restitution, SEED, scene.drop_height)
        share = np.array(
            [pose.count for pose in sorted(counted.poses, key=lambda pose: pose.index)],
            dtype=float,
        )
        share /= share.sum()
        noise = float(np.mean(share * (1.0 - share))) / (DROPS - counted.unsettled - 1)
        for method, some in squares.items():
            told = ESTIMATORS[method].function(resting, scene)
            some.append(float(np.mean(np.square(told - share))) - noise)
            largest[method] = max(largest[method], float(np.abs(told - share).max()))
            if method == "split":
                expected.append(expected_error(method, resting, told, scene).here ** 2)
    return PartScore(
        name,
        len(resting.poses),
        height,
        _root(squares["split"]),
        _root(squares["combined"]),
        _root(expected),
        100.0 * largest["split"],
        100.0 * largest["combined"],
    )


def _root(squares: Sequence[float]) -> float:
    return 100.0 * float(np.sqrt(max(np.mean(squares), 0.0)))
