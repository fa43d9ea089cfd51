"""Drop simulations for the other measurements."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.action import ActionClient
from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.action import SimulateDrops

from lab.bodies.curved import Body
from ros_pose_stats import part_from_mesh

from .client import OWN, Client
from .mesh_to_estimate import PART_TOPIC, part_mesh_bytes

ENDLESS = 10_000_000
RUNNING = srv.GetDropSimulation.Response.RUNNING
DONE = srv.GetDropSimulation.Response.DONE
SEEDS = count(1)


def make_known(client: Client, part_id: str, body: Body) -> None:
    """Send a part, and wait until it is estimated."""
    digest = part_from_mesh(body.vertices, body.triangles).digest
    client.publish_until_latched(
        PART_TOPIC, part_mesh_bytes(part_id, body.vertices, body.triangles), digest
    )


def start_request(part_id: str, drops: int) -> Any:
    """A request with a seed of its own."""
    return srv.StartDropSimulation.Request(
        part_id=part_id, drops=drops, seed=next(SEEDS)
    )


def carry(
    request: Any,
    part_id: str,
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
) -> Any:
    """Put the part into a request, as flat arrays."""
    request.part.part_id = part_id
    request.part.vertices = array("d", np.ascontiguousarray(vertices).tobytes())
    request.part.triangles = array("I", triangles.astype(np.uint32).tobytes())
    return request


def start(client: Client, request: Any) -> str:
    """Start a simulation and get its id.

    Raises
    ------
    RuntimeError
        With the message of a refusal.
    """
    return str(
        accepted(
            client.call(srv.StartDropSimulation, "start_drop_simulation", request)
        ).job_id
    )


def accepted(response: Any) -> Any:
    """Return the response if it says success."""
    if not response.success:
        raise RuntimeError(response.message)
    return response


def state(client: Client, job_id: str) -> Any:
    """State of a job."""
    return accepted(
        client.call(
            srv.GetDropSimulation,
            "get_drop_simulation",
            srv.GetDropSimulation.Request(job_id=job_id),
        )
    )


def wait_for_end(client: Client, job_id: str) -> Any:
    """Wait until a job has ended."""
    while (answer := state(client, job_id)).status.state < DONE:
        client.spin_for(0.005)
    return answer


def wait_for_drops(client: Client, job_id: str) -> None:
    """Wait until a job has begun to drop."""
    while not state(client, job_id).status.drops_done:
        client.spin_for(0.01)


def cancel(client: Client, job_id: str) -> Any:
    """Cancel a job, which may have ended."""
    return client.call(
        srv.CancelDropSimulation,
        "cancel_drop_simulation",
        srv.CancelDropSimulation.Request(job_id=job_id),
    )


@contextmanager
def under_way(client: Client, part_id: str) -> Iterator[str]:
    """A simulation on all workers of the node for as long as the context lasts.

    Raises
    ------
    RuntimeError
        If it ended before the context.
    """
    job_id = start(client, start_request(part_id, ENDLESS))
    wait_for_drops(client, job_id)
    yield job_id
    lasted = state(client, job_id).status.state == RUNNING
    cancel(client, job_id)
    wait_for_end(client, job_id)
    if not lasted:
        raise RuntimeError(f"{job_id} ended too early")


@contextmanager
def action_client(client: Client) -> Iterator[Any]:
    """A client of the action whose server is ready."""
    action = ActionClient(client.node, SimulateDrops, f"{OWN}/simulate_drops")
    try:
        client.spin_until(action.server_is_ready, "action server")
        yield action
    finally:
        action.destroy()
