"""Everything about the node that is measured, section after section."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

from rclpy.utilities import get_rmw_implementation_identifier
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh

from ros_pose_stats import part_from_mesh

from ..bodies import Body, demo_parts, near_sphere, random_polyhedron
from ..command import command
from ..report import collected
from ..results import Results, Section
from . import jobs, meshes
from .bag_bytes import bag_bytes
from .bare import MESHES, RAW_MESHES
from .cancelling import cancelling
from .child import bare, node
from .client import Client
from .disk import disk
from .drop_rates import drop_rates
from .feedback import feedback
from .limits import limits
from .mesh_to_estimate import CAD_TOPIC, PART_TOPIC, mesh_to_estimate
from .plan import QUICK, Plan
from .services import Known, services
from .starting import starting
from .subscriptions import subscriptions
from .surroundings import cores, surroundings

MILLIMETRE = 1e-3
CLAMP, LARGE = "clamp", "large"


def sections(plan: Plan) -> Iterator[Section]:
    """Measure and hand over one table after the other."""
    with surroundings() as folder:
        yield starting(folder / "starts", plan.starts)
        yield disk(folder / "disk", plan.disk)
        bags = folder / "bags"
        with bare(), node(bags, [f"cad={CAD_TOPIC}"], cores()) as running, Client() as client:
            for kind, topic in ((PartMesh, PART_TOPIC), (Mesh, CAD_TOPIC), (Mesh, MESHES),
                                (Mesh, RAW_MESHES)):
                client.connect(kind, topic)
            try:
                yield from _of_running(client, plan, bags)
            except (TimeoutError, RuntimeError) as error:
                raise RuntimeError(running.complaint(str(error))) from error


def _of_running(client: Client, plan: Plan, bags: Path) -> Iterator[Section]:
    bodies = [make(size) for size in plan.triangles for make in (meshes.ring, meshes.rounded)]
    yield mesh_to_estimate(client, bodies, plan.meshes)
    yield subscriptions(client, bodies[-2], plan.ordinary)
    clamp, carried = _clamp(), meshes.rounded(plan.carried)
    jobs.make_known(client, CLAMP, clamp)
    jobs.make_known(client, LARGE, carried)
    parts = {CLAMP: "clamp", LARGE: carried.name}
    yield services(client, Known(CLAMP, LARGE, carried), plan.services)
    yield limits(client, CLAMP, _many_poses(plan.many), bodies[-2], plan.jobs, plan.limits)
    yield cancelling(client, parts, plan.cancels)
    yield feedback(client, parts, plan.feedback_seconds)
    yield drop_rates(client, CLAMP, part_from_mesh(clamp.vertices, clamp.triangles), plan.drops,
                     plan.rates)
    yield bag_bytes(client, random_polyhedron(10, 2), bags)


def _clamp() -> Body:
    """The demo part, in metres."""
    body = next(body for body in demo_parts() if body.name == CLAMP)
    return body._replace(vertices=MILLIMETRE * body.vertices)


def _many_poses(vertices: int) -> Body:
    """About a seventh as many stable poses."""
    body = near_sphere(vertices)
    return body._replace(vertices=meshes.LENGTH * body.vertices)


def run(plan: Plan, said: Callable[[str], object] = print) -> Results:
    """Measure everything, telling each table as it comes."""
    found = collected(sections(plan), said)
    return replace(found, machine={**found.machine, "rclpy": version("rclpy"),
                                   "middleware": get_rmw_implementation_identifier()})


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print, and with `--write` store the results and render the page."""
    command("node", __doc__, "fewer meshes and calls",
            lambda quick: run(QUICK if quick else Plan()), arguments)
