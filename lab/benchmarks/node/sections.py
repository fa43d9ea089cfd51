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

"""All measurements of the node, section after section."""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version

from rclpy.utilities import get_rmw_implementation_identifier
from shape_msgs.msg import Mesh

from lab.bodies.curved import Body, ring_of, rounded_box_of
from lab.frame.results import Section
from lab.frame.timing import Pace
from ros_pose_stats.core.shapes.demo_parts import DEMO_PARTS
from tests.contract.node.harness.cell import MeshPublisher
from tests.contract.node.harness.client import Client
from tests.contract.node.harness.parts import flat

from .bare import PREFIX
from .crowd import crowd
from .listener import Listener
from .mesh_to_estimate import CAD_TOPIC, Topics, mesh_to_estimate
from .services import Known, services
from .starting import OWN, bare_process, cores, node, starting, surroundings

MILLIMETRE = 1e-3
CLAMP = "clamp"
LARGE = "large"
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
    crowd_seconds : float
        Of each call that many clients make.
    """

    starts: int = 3
    triangles: tuple[int, ...] = (1000, 10_000, 100_000)
    meshes: Pace = MESHES_EACH
    services: Pace = CALLS
    carried: int = 10_000
    crowd_seconds: float = 20.0


QUICK = Plan(
    starts=1,
    triangles=(1000, 10_000),
    meshes=Pace(10, 0.5),
    services=Pace(12, 1.0),
    crowd_seconds=2.0,
)


def sections(plan: Plan) -> Iterator[Section]:
    """Measure, and yield one table after the other."""
    with surroundings() as (folder, domain):
        yield starting(domain, folder / "starts", plan.starts)
        bags = folder / "bags"
        topics = f"[cad={CAD_TOPIC}]"
        with (
            Client(domain, OWN) as client,
            Client(domain, PREFIX) as bare_client,
            bare_process(bags) as bare,
            node(bags, mesh_topics=topics, workers=cores()) as running,
        ):
            bare.ready()
            running.ready()
            yield from _of_running(client, bare_client, plan)


def _of_running(client: Client, bare_client: Client, plan: Plan) -> Iterator[Section]:
    listener = Listener(client)
    topics = Topics(
        listener,
        MeshPublisher(client).matched(),
        MeshPublisher(client, CAD_TOPIC, Mesh).matched(),
    )
    bodies = [
        make(size) for size in plan.triangles for make in (ring_of, rounded_box_of)
    ]
    yield mesh_to_estimate(topics, bodies, plan.meshes)
    carried = rounded_box_of(plan.carried)
    for part_id, body in ((CLAMP, _clamp()), (LARGE, carried)):
        client.good("estimate", part=flat(body[1:], part_id))
    known = Known(CLAMP, LARGE, carried)
    yield services(client, bare_client, listener, known, plan.services)
    yield crowd(CLAMP, plan.crowd_seconds)


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
