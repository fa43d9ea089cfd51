"""Judges what estimates of lopsided round parts tell of their error.

.venv/bin/python -m lab.training.lopsided             300 parts, some minutes
.venv/bin/python -m lab.training.lopsided --write     writes docs/measured/lopsided.md, too
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from manifold3d import Manifold
from numpy.random import Generator

from ros_pose_stats import part_from_mesh, shift_center, simulate
from ros_pose_stats.core.estimators.expected import (
    ExpectedError,
    expected_error,
    largest_of,
)
from ros_pose_stats.core.estimators.fitted import ERROR_FITS
from ros_pose_stats.core.estimators.split import split
from ros_pose_stats.core.records import DropScene, Part
from ros_pose_stats.core.resting.poses import RestingPoses, resting_poses
from ros_pose_stats.core.shapes.demo_parts import surface_of
from study.output import markdown_table, points, write_page

DOCS: Final = Path(__file__).resolve().parents[2] / "docs"
SEED: Final = 417
DROPS: Final = 250
SIDES: Final = 192
RESTITUTIONS: Final = (0.1, 0.2, 0.35, 0.5, 0.65, 0.8)
BINS: Final = (0.0, 0.01, 0.02, 0.04, 0.08, 0.2, 1.0)
"""Offsets of the centre of mass from the axis, in radii, between which parts share a row."""


class Case(NamedTuple):
    """A part, estimated and dropped."""

    offset: float  # of the centre of mass from the axis, in radii
    square: float  # mean over the poses, the noise of the drops taken off
    before: float  # expected error without what rolling may gain
    told: float  # and with it
    kept: bool  # whether the drops are within `largest_error` and their noise, at 90 %


def lopsided_part(draw: Generator) -> Part:
    """A disc, shaft or cam whose centre of mass lies beside the axis of its round surface."""
    length = float(np.exp(draw.uniform(math.log(0.12), math.log(3.0))))
    whole = _cylinder(length, 1.0)
    kind = int(draw.integers(4))
    if kind == 0:
        offset = float(np.exp(draw.uniform(math.log(0.004), math.log(0.35))))
        return shift_center(part_from_mesh(*surface_of(whole)), (offset, 0.0, 0.0))
    radius = draw.uniform(0.15, 0.6)
    beside = draw.uniform(0.02, 0.95 - radius)
    if kind == 1:
        whole -= _cylinder(length + 2.0, radius).translate((beside, 0.0, -1.0))
    elif kind == 2:
        whole -= _cylinder(length + 2.0, radius).translate(
            (beside, 0.0, length * draw.uniform(0.2, 0.8))
        )
    else:
        whole += _cylinder(draw.uniform(0.1, 1.0), radius).translate(
            (beside, 0.0, 0.999 * length)
        )
    return part_from_mesh(*surface_of(whole))


def _cylinder(length: float, radius: float) -> Manifold:
    return Manifold.cylinder(length, radius, circular_segments=SIDES)


def measure(number: int, workers: int | None = None) -> Case:
    """Estimate and drop the part of a number, in a scene of its own."""
    draw = np.random.default_rng([SEED, number])
    part = lopsided_part(draw)
    resting = resting_poses(part)
    scene = DropScene(
        float(draw.choice(RESTITUTIONS)),
        resting.body.radius * float(np.exp(draw.uniform(*np.log([2.0, 80.0])))),
    )
    told = split(resting, scene)
    expected = expected_error("split", resting, told, scene)
    found = simulate(
        part,
        DROPS,
        restitution=scene.restitution,
        drop_height=scene.drop_height,
        seed=number,
        workers=workers,
    )
    count = np.zeros(told.size)
    count[[pose.index for pose in found.poses]] = [pose.count for pose in found.poses]
    return _judge(resting, told, expected, count)


def _judge(
    resting: RestingPoses, told: np.ndarray, expected: ExpectedError, count: np.ndarray
) -> Case:
    drops = float(count.sum())
    share = count / drops
    likely = (count + 0.5) / (drops + 1.0)
    away = share - told
    noise = likely * (1.0 - likely) / drops
    bound = largest_of(expected.each, resting.group, ERROR_FITS["split"], noise)
    return Case(
        float(resting.axis_offsets.max()),
        float(np.mean(away * away - share * (1.0 - share) / drops)),
        math.sqrt(max(expected.here**2 - expected.rolled**2, 0.0)),
        expected.here,
        bool(np.abs(away).max() <= bound),
    )


def table(cases: Sequence[Case]) -> str:
    """True and told errors by the offset of the centre of mass."""
    rows = []
    for low, high in pairwise(BINS):
        some = [one for one in cases if low <= one.offset < high]
        if some:
            rows.append((f"{low:g} to {high:g}", some))
    rows.append(("all", list(cases)))
    head = (
        "offset, radii",
        "parts",
        "true, points",
        "told without rolling",
        "told",
        "largest error kept, %",
    )
    return markdown_table(
        head, [(name, f"{len(some)}", *summary(some)) for name, some in rows]
    )


def summary(some: Sequence[Case]) -> tuple[str, str, str, str]:
    """True error, both told ones and the share that keeps `largest_error`, in words."""
    square = [
        float(np.mean([getattr(one, name) ** 2 for one in some]))
        for name in ("before", "told")
    ]
    true = math.sqrt(max(float(np.mean([one.square for one in some])), 0.0))
    return (
        points(true),
        *(points(math.sqrt(one)) for one in square),
        points(float(np.mean([one.kept for one in some])), 0),
    )


def page(cases: Sequence[Case]) -> str:
    """The page docs/measured/lopsided.md."""
    return f"""# Round parts with the centre of mass beside their axis

Written by `python -m lab.training.lopsided --write`; edits here are lost. {len(cases)} discs,
shafts and cams, some with a hole beside the axis, at restitution {RESTITUTIONS[0]:g} to
{RESTITUTIONS[-1]:g}, released from 2 to 80 radii, {DROPS} drops of each. *True* is the root mean
square error of `split` over all poses, the noise of the drops taken off; *told* its expected
error, without and with what such parts gain by rolling ([methods](../methods.md)). The largest
error is kept where no pose's share of the drops is off by more, their noise allowed for.

{table(cases)}
"""


def main() -> None:
    """Measure, print the page, and write it where that is asked."""
    parser = argparse.ArgumentParser(
        prog="lab.training.lopsided", description=__doc__.partition("\n")[0]
    )
    parser.add_argument("--parts", type=int, default=300, help="(default: %(default)s)")
    parser.add_argument(
        "--write", action="store_true", help="write what is found to its place"
    )
    options = parser.parse_args()
    text = page([measure(number) for number in range(options.parts)])
    print(text)
    if options.write:
        write_page(DOCS, "lopsided.md", text, {}, {})


if __name__ == "__main__":
    main()
