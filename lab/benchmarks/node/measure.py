"""All measurements of the node, section after section."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path

from rclpy.utilities import get_rmw_implementation_identifier
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh

from ros_pose_stats import part_from_mesh

from ..bodies import Body, demo_parts, near_sphere, random_polyhedron
from ..report import collect_results, command
from ..results import Results, Section
from ..timing import Pace
from . import jobs
from .bare import MESHES, RAW_MESHES
from .client import Client
from .drop_jobs import cancelling, drop_rates, feedback
from .limits import limits
from .mesh_to_estimate import (
    CAD_TOPIC,
    LENGTH,
    PART_TOPIC,
    mesh_to_estimate,
    ring,
    rounded,
    subscriptions,
)
from .processes import bare, cores, node, starting, surroundings
from .recording import bag_bytes, disk
from .services import Known, services

MILLIMETRE = 1e-3
CLAMP = "clamp"
LARGE = "large"


def sections(plan: Plan) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    with surroundings() as folder:
        yield starting(folder / "starts", plan.starts)
        yield disk(folder / "disk", plan.disk)
        bags = folder / "bags"
        with (
            bare(),
            node(bags, [f"cad={CAD_TOPIC}"], cores()) as running,
            Client() as client,
        ):
            for kind, topic in (
                (PartMesh, PART_TOPIC),
                (Mesh, CAD_TOPIC),
                (Mesh, MESHES),
                (Mesh, RAW_MESHES),
            ):
                client.connect(kind, topic)
            try:
                yield from _of_running(client, plan, bags)
            except (TimeoutError, RuntimeError) as error:
                raise RuntimeError(running.complaint(str(error))) from error


def _of_running(client: Client, plan: Plan, bags: Path) -> Iterator[Section]:
    bodies = [make(size) for size in plan.triangles for make in (ring, rounded)]
    yield mesh_to_estimate(client, bodies, plan.meshes)
    yield subscriptions(client, bodies[-2], plan.ordinary)
    clamp = _clamp()
    carried = rounded(plan.carried)
    jobs.make_known(client, CLAMP, clamp)
    jobs.make_known(client, LARGE, carried)
    parts = {CLAMP: "clamp", LARGE: carried.name}
    yield services(client, Known(CLAMP, LARGE, carried), plan.services)
    yield limits(
        client, CLAMP, _many_poses(plan.many), bodies[-2], plan.jobs, plan.limits
    )
    yield cancelling(client, parts, plan.cancels)
    yield feedback(client, parts, plan.feedback_seconds)
    yield drop_rates(
        client,
        CLAMP,
        part_from_mesh(clamp.vertices, clamp.triangles),
        plan.drops,
        plan.rates,
    )
    yield bag_bytes(client, random_polyhedron(10, 2), bags)


def _clamp() -> Body:
    """The demo part, in metres."""
    body = next(body for body in demo_parts() if body.name == CLAMP)
    return body._replace(vertices=MILLIMETRE * body.vertices)


def _many_poses(vertices: int) -> Body:
    """A body with about a seventh as many stable poses as vertices."""
    body = near_sphere(vertices)
    return body._replace(vertices=LENGTH * body.vertices)


def run(plan: Plan, say: Callable[[str], object] = print) -> Results:
    """Measure everything, and say each table as it comes."""
    found = collect_results(sections(plan), say)
    return replace(
        found,
        machine={
            **found.machine,
            "rclpy": version("rclpy"),
            "middleware": get_rmw_implementation_identifier(),
        },
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print, and with `--write` store the results and render the page."""
    command(
        "node",
        __doc__,
        "fewer meshes and calls",
        lambda quick: run(QUICK if quick else Plan()),
        arguments,
    )


MESHES_EACH = Pace(60, 2.0)
PLAIN = Pace(5, 4.0)
DISK = Pace(300, 2.0)
CALLS = Pace(100, 6.0)
LIMITS = Pace(40, 3.0)
RATES = Pace(5, 8.0)


@dataclass(frozen=True)
class Plan:
    """How much to measure.

    Attributes
    ----------
    starts : int
        Of the node and of the bare process.
    triangles : tuple of int
        Of the meshes that are estimated, rising.
    meshes, ordinary, disk, services, rates : Pace
    carried : int
        Triangles of the part that requests carry.
    many : int
        Vertices of the part with many poses.
    jobs : int
        Jobs that the node is to know; it keeps 1000.
    limits : Pace
    cancels : int
        For each part and way.
    feedback_seconds : float
    drops : int
        Of a job beside the library.
    """

    starts: int = 3
    triangles: tuple[int, ...] = (1000, 10_000, 100_000)
    meshes: Pace = MESHES_EACH
    ordinary: Pace = PLAIN
    disk: Pace = DISK
    services: Pace = CALLS
    carried: int = 10_000
    many: int = 4000
    jobs: int = 900
    limits: Pace = LIMITS
    cancels: int = 25
    feedback_seconds: float = 3.0
    drops: int = 40_000
    rates: Pace = RATES


QUICK = Plan(
    starts=1,
    triangles=(1000, 10_000),
    meshes=Pace(10, 0.5),
    ordinary=Pace(2, 2.0),
    disk=Pace(50, 0.5),
    services=Pace(12, 1.0),
    many=500,
    jobs=50,
    limits=Pace(5, 0.5),
    cancels=3,
    feedback_seconds=1.0,
    drops=10_000,
    rates=Pace(2, 2.0),
)
