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

"""The chart of speed against accuracy: plans of its measurements, and its numbers as a
table.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from lab.frame.documents import markdown_table, plain, points
from ros_pose_stats.core.records.scene import describe_scene

from ..dataset import Dataset, DatasetSpec
from ..figures.speed_accuracy import ChartPanel, ChartPoint, pareto_front
from .bodies import Size, ellipsoids, machined_parts, paper_size
from .methods import (
    Effort,
    combined_points,
    default_point,
    estimator_points,
    simulation_points,
)
from .other_software import trimesh_points


class Plan(NamedTuple):
    """Measurements of one size or kind of part.

    Attributes
    ----------
    vertices : int
        Of the bodies; 0 for those of the dataset, or the machined ones.
    bodies, drops : int
        Bodies to simulate as the reference, and drops of each at each restitution.
    effort : Effort
    trimesh : int
        Number of bodies for this software.
    machined : bool
        Whether these are machined and turned parts.
    """

    vertices: int
    bodies: int
    drops: int
    effort: Effort
    trimesh: int
    machined: bool = False


FEW_DROPS = (10, 100, 1_000)
FEWER_DROPS = (10, 100)

PLANS = (
    Plan(0, 0, 0, Effort(), 1_000_000),
    Plan(200, 60, 1_000, Effort(40, 10_000), 60),
    Plan(2_000, 20, 400, Effort(20, 2_000, FEW_DROPS, FEWER_DROPS, 1), 20),
    Plan(0, 60, 2_000, Effort(30, 10_000), 60, machined=True),
)
"""Ten thousand drops of the largest take minutes: what they would show, fewer do."""

QUICK = (
    Plan(0, 0, 0, Effort(9, 1_000, FEW_DROPS, FEWER_DROPS), 30),
    Plan(200, 8, 200, Effort(8, 1_000, FEW_DROPS, FEWER_DROPS), 8),
    Plan(0, 12, 400, Effort(12, 1_000, FEW_DROPS, FEWER_DROPS), 12, machined=True),
)


class MeasuredSize(NamedTuple):
    """A panel of the chart, with facts about its bodies."""

    title: str
    bodies: int
    mean_poses: float
    reference_drops: int
    points: tuple[ChartPoint, ...]

    def front(self) -> list[int]:
        """Places of the points that no other one beats in both."""
        return pareto_front(self.points)

    def panel(self) -> ChartPanel:
        """Panel of the figure; an error of 0 has no place on a logarithmic axis."""
        return ChartPanel(
            self.title, [point for point in self.points if point.error > 0.0]
        )


@dataclass(frozen=True, eq=False)
class ChartResults:
    """Everything behind the chart.

    Attributes
    ----------
    spec : DatasetSpec
        Of the paper-size bodies.
    sizes : tuple of Measured
    seconds : float
    """

    spec: DatasetSpec
    sizes: tuple[MeasuredSize, ...]
    seconds: float

    @property
    def scene(self) -> str:
        """How high all bodies were released, onto what, and how bouncy, in one
        sentence.
        """
        return describe_scene(self.spec.restitutions, None)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "scene": self.scene,
            "dataset": self.spec.as_dict(),
            "seconds": self.seconds,
            "sizes": [
                {**plain(size), "pareto_front": size.front()} for size in self.sizes
            ],
        }


def chart(
    dataset: Dataset,
    plans: tuple[Plan, ...] = PLANS,
    *,
    on_progress: Callable[[str], object] = lambda _: None,
) -> ChartResults:
    """Time and error of every method for each size of part.

    Parameters
    ----------
    dataset : Dataset
        Of the paper-size bodies.
    plans : tuple of Plan
    on_progress : callable, optional
        Told what is being measured.
    """
    begin = time.perf_counter()
    panels = []
    for plan in plans:
        on_progress("reading or simulating the bodies of a size")
        size = _planned_bodies(dataset, plan)
        points = []
        for point in _points(size, plan):
            points.append(point)
            series = f"{point.series}, " if point.series else ""
            on_progress(f"{size.title}: {series}{point.name}")
        poses = sum(len(resting.poses) for resting in size.restings)
        panels.append(
            MeasuredSize(
                size.title,
                len(size.meshes),
                poses / len(size.meshes),
                plan.drops or dataset.spec.drops,
                tuple(points),
            )
        )
    return ChartResults(dataset.spec, tuple(panels), time.perf_counter() - begin)


def _planned_bodies(dataset: Dataset, plan: Plan) -> Size:
    if plan.machined:
        return machined_parts(plan.bodies, plan.drops, dataset.spec.restitutions)
    if plan.vertices == 0:
        return paper_size(dataset)
    return ellipsoids(plan.vertices, plan.bodies, plan.drops, dataset.spec.restitutions)


def _points(size: Size, plan: Plan) -> Iterator[ChartPoint]:
    yield from estimator_points(size, plan.effort)
    answered = size.first(plan.effort.answered)
    yield default_point(answered)
    yield from combined_points(answered, plan.effort)
    yield from simulation_points(size, plan.effort)
    yield from trimesh_points(size.first(plan.trimesh))


def chart_text(results: ChartResults) -> str:
    """The scene, and a table for each kind of part; methods that nothing beats are
    marked.
    """
    scene = f"{results.scene[0].upper()}{results.scene[1:]}."
    return "\n\n".join([scene, *(_size_text(size) for size in results.sizes)])


def _size_text(size: MeasuredSize) -> str:
    front = set(size.front())
    rows = []
    for k, point in sorted(enumerate(size.points), key=lambda entry: entry[1].seconds):
        name = f"{point.series}, {point.name}" if point.series else point.name
        rows.append(
            (
                name,
                duration(point.seconds),
                points(point.error, 2),
                f"{points(max(point.low, 0.0), 2)} to {points(point.high, 2)}",
                "yes" if k in front else "",
            )
        )
    head = ("method", "time a part", "error, points", "95 % interval", "on the front")
    return (
        f"### {size.title}\n\n{size.bodies} bodies with {size.mean_poses:.1f} stable "
        f"poses on average, {size.reference_drops} reference drops of each at each "
        "restitution.\n\n" + markdown_table(head, rows)
    )


def duration(seconds: float) -> str:
    """Three digits in the unit that fits."""
    for unit, size in (("µs", 1e-6), ("ms", 1e-3)):
        if seconds < 1000.0 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"
