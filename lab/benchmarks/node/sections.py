"""All measurements of the node, section after section."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version

from rclpy.utilities import get_rmw_implementation_identifier
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh

from lab.bodies.curved import Body, ring_of, rounded_box_of
from lab.frame.results import Section
from lab.frame.timing import Pace
from ros_pose_stats.core.shapes.demo_parts import DEMO_PARTS

from . import jobs
from .cancelling import cancelling
from .client import Client
from .mesh_to_estimate import CAD_TOPIC, PART_TOPIC, mesh_to_estimate
from .processes import bare, cores, node, starting, surroundings
from .services import Known, services

MILLIMETRE = 1e-3
CLAMP = "clamp"
LARGE = "large"


def sections(plan: Plan) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    with surroundings() as folder:
        yield starting(folder / "starts", plan.starts)
        with (
            bare(),
            node(folder / "bags", [f"cad={CAD_TOPIC}"], cores()) as running,
            Client() as client,
        ):
            client.connect(PartMesh, PART_TOPIC)
            client.connect(Mesh, CAD_TOPIC)
            try:
                yield from _of_running(client, plan)
            except (TimeoutError, RuntimeError) as error:
                raise RuntimeError(running.complaint(str(error))) from error


def _of_running(client: Client, plan: Plan) -> Iterator[Section]:
    bodies = [
        make(size) for size in plan.triangles for make in (ring_of, rounded_box_of)
    ]
    yield mesh_to_estimate(client, bodies, plan.meshes)
    carried = rounded_box_of(plan.carried)
    jobs.make_known(client, CLAMP, _clamp())
    jobs.make_known(client, LARGE, carried)
    yield services(client, Known(CLAMP, LARGE, carried), plan.services)
    yield cancelling(client, {CLAMP: "clamp", LARGE: carried.name}, plan.cancels)


def _clamp() -> Body:
    """The demo part, in metres."""
    vertices, triangles = DEMO_PARTS[CLAMP]()
    return Body(CLAMP, MILLIMETRE * vertices, triangles)


def middleware() -> dict[str, str]:
    """What the times hang on beside the machine."""
    return {
        "rclpy": version("rclpy"),
        "middleware": get_rmw_implementation_identifier(),
    }


MESHES_EACH = Pace(60, 2.0)
CALLS = Pace(100, 6.0)


@dataclass(frozen=True)
class Plan:
    """How much to measure.

    Attributes
    ----------
    starts : int
        Of the node and of the bare process.
    triangles : tuple of int
        Of the meshes that are estimated, rising.
    meshes, services : Pace
    carried : int
        Triangles of the part that requests carry.
    cancels : int
        For each part and way.
    """

    starts: int = 3
    triangles: tuple[int, ...] = (1000, 10_000, 100_000)
    meshes: Pace = MESHES_EACH
    services: Pace = CALLS
    carried: int = 10_000
    cancels: int = 25


QUICK = Plan(
    starts=1,
    triangles=(1000, 10_000),
    meshes=Pace(10, 0.5),
    services=Pace(12, 1.0),
    cancels=3,
)
