"""Cost against the number of vertices at a fixed number of stable poses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from ros_pose_stats import Part, estimate, estimate_all, part_from_mesh, resting_poses
from ros_pose_stats.core.resting.equilibria import equilibria

from .bodies import Body
from .results import Row, Section, Target
from .timing import Contender, Pace, race

STABLE = 6
STEEPEST = 1.2
FIT_FROM = 500
"""Vertices from which on slopes are fitted: fixed costs no longer show."""
DECADE = 1.1
"""Factor by which a body may lie outside the last decade and still count."""
TOLERANCE = 0.0

HULL = "scipy hull"
MESH = "mesh to part"
BODY = "body + equilibria"
SPLITS = "MEAE splits"
AFTER = "MEAE after the hull"
ALL = "all estimators from the mesh"
STAGES = (HULL, MESH, BODY, SPLITS, AFTER, ALL)

TIMED = (
    f"Every body has exactly {STABLE} stable faces, checked. `{HULL}`: "
    f"`scipy.spatial.ConvexHull` of the vertices. `{MESH}`: `part_from_mesh`, with its own "
    f"hull. `{BODY}`: merged faces, their lengths and angles, basins, merge tree and toppling "
    f"graph, the hull known. `{SPLITS}`: the split probabilities for r, all else known. "
    f"`{AFTER}`: `estimate(part, 'meae')` on a part of which only the hull is known: "
    f"`{BODY}`, poses, symmetry groups, `{SPLITS}` and records. `{ALL}`: `{MESH}` and "
    "`estimate_all`. Milliseconds; cluster tolerance 0."
)


class Slope(NamedTuple):
    """Exponent of a power law, with its standard error from the scatter about the line."""

    value: float
    error: float


def growth(bodies: Sequence[Body], pace: Pace) -> Section:
    """A row for each body, in the order given.

    Raises
    ------
    ValueError
        If a body has another number of stable faces.
    """
    return Section(
        "growth",
        f"Cost against vertices at {STABLE} stable poses",
        TIMED,
        tuple(_row(body, pace) for body in bodies),
    )


def slopes(growth: Section, from_vertices: int = FIT_FROM) -> Section:
    """Fit the exponent of each stage for each family of bodies in the rows of `growth`."""
    families = dict.fromkeys(family(row) for row in growth.rows)
    rows = [
        _slope_row(growth, name, stage, from_vertices)
        for name in families
        for stage in STAGES
    ]
    return Section(
        "slopes",
        "Slopes on the log-log plot",
        (
            f"Least squares of log time on log vertices from {from_vertices} vertices on, and over "
            "the last decade alone; 1 is proportional to the number of vertices. Errors are standard "
            "errors from the scatter about the line. A curve is steeper at its end than over all: "
            "fixed costs still show at the beginning, and the largest bodies outgrow the "
            "processor's caches, scipy's hull among them."
        ),
        tuple(rows),
    )


def family(row: Row) -> str:
    """Family of bodies that a row of `growth` belongs to: its name up to the size."""
    return row.name.partition(",")[0]


def fit_slope(vertices: ArrayLike, seconds: ArrayLike) -> Slope:
    """Slope of a straight line through the logarithms of at least three points.

    Raises
    ------
    ValueError
        If there are fewer, so that the error is not known.
    """
    if np.size(vertices) < 3:
        raise ValueError(f"a slope needs three points, not {np.size(vertices)}")
    x = np.log(np.asarray(vertices, float))
    y = np.log(np.asarray(seconds, float))
    away = x - x.mean()
    spread = float(away @ away)
    value = float(away @ y) / spread
    rest = y - y.mean() - value * away
    return Slope(value, float(rest @ rest / (len(x) - 2) / spread) ** 0.5)


def _row(body: Body, pace: Pace) -> Row:
    known = part_from_mesh(body.vertices, body.triangles)
    resting = resting_poses(known, TOLERANCE, round_sides=0)
    if len(resting.poses) != STABLE:
        raise ValueError(
            f"{body.name} with {len(body.vertices)} vertices: "
            f"{len(resting.poses)} stable faces, not {STABLE}"
        )

    def part(_: object = None) -> Part:
        return part_from_mesh(body.vertices, body.triangles)

    def forget() -> None:
        vars(resting).pop("passage_r", None)

    calls: dict[str, tuple[Callable[..., object], Callable[[], object]]] = {
        HULL: (lambda _: ConvexHull(body.vertices), lambda: None),
        MESH: (part, lambda: None),
        BODY: (lambda made: equilibria(made, 0), part),
        SPLITS: (lambda _: resting.passage_r, forget),
        AFTER: (
            lambda made: estimate(
                made, "meae", cluster_tolerance=TOLERANCE, round_sides=0
            ),
            part,
        ),
        ALL: (
            lambda _: estimate_all(part(), cluster_tolerance=TOLERANCE, round_sides=0),
            lambda: None,
        ),
    }
    timings = race([Contender(stage, *calls[stage]) for stage in STAGES], pace)
    return Row(
        f"{body.name}, {len(body.vertices)} vertices",
        {
            "vertices": len(body.vertices),
            "faces": resting.body.faces,
            **{stage: timings.milliseconds(stage) for stage in STAGES},
            "all / hull": timings.ratio(ALL, HULL),
        },
    )


def _slope_row(growth: Section, name: str, stage: str, from_vertices: int) -> Row:
    used = [
        row.cells
        for row in growth.rows
        if family(row) == name and int(row.cells["vertices"]) >= from_vertices
    ]
    vertices = [int(cells["vertices"]) for cells in used]
    milliseconds = [float(cells[stage]) for cells in used]
    last = sum(10 * DECADE * count >= vertices[-1] for count in vertices)
    whole = fit_slope(vertices, milliseconds)
    end = fit_slope(vertices[-last:], milliseconds[-last:])
    return Row(
        f"{name}: {stage}",
        {
            "slope": whole.value,
            "error": whole.error,
            "points": len(used),
            "from": vertices[0],
            "to": vertices[-1],
            "last decade": end.value,
            "its error": end.error,
            "its points": last,
        },
        (
            Target("slope", whole.value, STEEPEST),
            Target("last decade", end.value, STEEPEST),
        )
        if stage == AFTER
        else (),
    )
