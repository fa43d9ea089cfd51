"""How far shares depend on how finely a file divides curves that are no circles.

`python -m lab.benchmarks.exports.curves [--drops N] [--write]`
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import trimesh

from ros_pose_stats import Part, estimate, resting_poses, simulate
from ros_pose_stats.core.resting.trust import curve_angle
from ros_pose_stats.core.tolerances import EXPORTS_DIFFER
from study import shapes

from ..report import MEASURED, NUMBERS, collect_results, table
from ..results import Results, Row, Section, Target, save
from . import parts

FLAT = 0.05
"""Solid angle, as a share of the sphere, of a face that is a flat and no facet of a curve."""

INTRODUCTION = """# Curves that are no circles

Written by `python -m lab.benchmarks.exports.curves --write`; edits here are lost.

Circles stand as polygons of 192 sides a turn whatever the file has; other curves stand as filed,
or thinned where they have thousands of corners. A body that rolls or rocks on them loses energy
at each facet, so its shares depend on the export, and nothing says which export is right: without
facets it would rock for ever. `COARSE_CURVE` warns of that.
"""

COMPARED = (
    "The share of poses on flat faces, in %, one number an export from the coarsest to the "
    "finest, at default settings: `split`, and {drops} drops. `angle`: by how much neighbouring "
    "facets turn, degrees, as the warning says it. `halving`: the largest change of the drops' "
    "share from one export to the next, a halving of the angle (more are shared out), and its "
    "standard error. `drops/s`: of the slowest export, on one core."
)


class Curve(NamedTuple):
    """A body as several files, the coarsest first."""

    name: str
    make: Callable[[int], shapes.Surface]
    divisions: tuple[int, ...]


def cut_ball(
    subdivisions: int, axes: Sequence[float] = (1.0, 1.0, 1.0), height: float = 0.7
) -> shapes.Surface:
    """An ellipsoid cut at that share of its lower radius."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    points = np.array(ball.vertices)
    edges = ball.edges_unique
    below = points[:, 2] < -height
    first, last = edges[below[edges[:, 0]] != below[edges[:, 1]]].T
    share = (-height - points[first, 2]) / (points[last, 2] - points[first, 2])
    crossing = points[first] + share[:, None] * (points[last] - points[first])
    return shapes.hull_mesh(np.vstack((points[~below], crossing)) * np.array(axes))


def lobed(sides: int, lobes: int, depth: float, length: float) -> shapes.Surface:
    """A prism over a rounded polygon."""
    angles = parts.circle(sides, 0.1)
    radius = 1.0 + depth * np.cos(lobes * angles)
    return parts.extruded(
        np.column_stack((radius * np.cos(angles), radius * np.sin(angles))), length
    )


BALLS = (2, 3, 4, 5)
AROUND = (24, 48, 96, 192)
CURVES = (
    Curve("ball, one flat", cut_ball, BALLS),
    Curve("egg, one flat", partial(cut_ball, axes=(1.0, 0.8, 1.3)), BALLS),
    Curve("ellipse, 0.6 : 1, 0.5 high", parts.ellipse, AROUND),
    Curve(
        "ellipse, 0.8 : 1, 1 high",
        partial(parts.ellipse, ratio=0.8, length=1.0),
        AROUND,
    ),
    Curve("rounded triangle", partial(lobed, lobes=3, depth=0.06, length=1.2), AROUND),
)


def on_flats(part: Part, shares: dict[int, float]) -> float:
    """Share of the poses that lie on a flat face."""
    resting = resting_poses(part)
    lowest = resting.equilibria.faces[resting.clusters.lowest]
    flat = resting.body.arrays.angle[lowest] > 4.0 * np.pi * FLAT
    return sum(share for index, share in shares.items() if flat[index])


def compare(curves: Sequence[Curve], drops: int) -> Section:
    """Table with a row for each body."""
    return Section(
        "curves",
        "One curve, many exports",
        COMPARED.format(drops=drops),
        tuple(_row(curve, drops) for curve in curves),
    )


def _row(curve: Curve, drops: int) -> Row:
    made = [
        parts.part_of(parts.in_float32(curve.make(number)))
        for number in curve.divisions
    ]
    angles = np.degrees([curve_angle(resting_poses(part)) for part in made])
    estimated = []
    counted = []
    rates = []
    for k, part in enumerate(made):
        estimated.append(
            on_flats(
                part,
                {
                    pose.index: pose.probability
                    for pose in estimate(part, "split").poses
                },
            )
        )
        begin = time.perf_counter()
        found = simulate(part, drops, seed=k, workers=1)
        rates.append(drops / (time.perf_counter() - begin))
        counted.append(
            on_flats(part, {pose.index: pose.probability for pose in found.poses})
        )
    share = np.array(counted)
    noise = np.sqrt(share * (1.0 - share) / drops)
    octaves = np.maximum(np.abs(np.log2(angles[:-1] / angles[1:])), 1.0)
    steps = np.abs(np.diff(share)) / octaves
    worst = int(steps.argmax())
    error = float(np.hypot(noise[worst], noise[worst + 1])) / float(octaves[worst])
    return Row(
        curve.name,
        {
            "angle": " ".join(f"{angle:.2g}" for angle in angles),
            "split": " ".join(f"{100.0 * one:.1f}" for one in estimated),
            "drops": " ".join(f"{100.0 * one:.1f}" for one in counted),
            "halving, points": 100.0 * float(steps[worst]),
            "±": 100.0 * error,
            "drops/s": min(rates),
        },
        (
            Target(
                "all exports warned", float((angles > 0.0).all()), 1.0, at_least=True
            ),
            Target(
                "halving less two standard errors, points",
                100.0 * float(steps[worst]) - 200.0 * error,
                float(EXPORTS_DIFFER),
            ),
        ),
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Compare, print, and with `--write` store the results and render the page."""
    parser = argparse.ArgumentParser(
        prog="lab.benchmarks.exports.curves", description=__doc__
    )
    parser.add_argument(
        "--drops", type=int, default=1000, help="of each export (default: %(default)s)"
    )
    parser.add_argument(
        "--write",
        action="store_true",
        help="store numbers/curves.json and write curves.md in docs/measured",
    )
    options = parser.parse_args(arguments)

    def sections() -> Iterator[Section]:
        yield compare(CURVES, options.drops)

    results = collect_results(sections(), print)
    if options.write:
        save(results, NUMBERS / "curves.json")
        write_page(results)


def write_page(results: Results) -> None:
    """Write `docs/measured/curves.md`."""
    (section,) = results.sections
    where = ", ".join(f"{name} {value}" for name, value in results.machine.items())
    (MEASURED / "curves.md").write_text(
        "\n".join(
            (
                INTRODUCTION,
                f"{section.timed}\n\n{table(section)}\n",
                f"Measured on: {where}.\n",
            )
        ),
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()
