"""Memory by many large parts, refused goals and requests that wait."""

from __future__ import annotations

from rclpy.action import ActionClient
from ros_pose_stats_msgs.action import SimulateDrops

from tests.ros.harness.client import until, wait_for
from tests.ros.harness.parts import flat

from .bodies import TRIANGLE_BYTES, fine_box
from .cell import attacked, resident
from .restarts import part_ids, publish_parts


def large_part(size, name, factor=1.0):
    """A message of about so many bytes."""
    vertices, triangles = fine_box(size / TRIANGLE_BYTES)
    return flat((vertices * factor, triangles), name)


def fill(domain, folder, parts, size, **values):
    """Publish parts, and as many again.

    Returns
    -------
    grown, later : int
        Bytes by which the node grew with the first half, and with the second.
    known : list of str
        Names of the parts in the end.
    """
    with attacked(domain, folder, **values) as (node, client):
        publish_parts(client, 1, size)
        before = resident(node)
        publish_parts(client, parts, size, first=1)
        between = resident(node)
        publish_parts(client, parts, size, first=1 + parts)
        return between - before, resident(node) - between, part_ids(client)


def refuse_goals(domain, folder, goals, size, **values):
    """Send goals that are refused, each with a mesh; bytes by which the node grew."""
    with attacked(domain, folder, max_drops=1000, **values) as (node, client):
        action = ActionClient(client.node, SimulateDrops, f"{client.prefix}/simulate_drops")
        until(action.server_is_ready, "the action")
        part = large_part(size, "refused")
        before = 0
        for number in range(goals + 1):
            goal = SimulateDrops.Goal(part=part, drops=2000)
            handle = wait_for(client.run(lambda goal=goal: action.send_goal_async(goal)))
            answer = wait_for(client.run(handle.get_result_async))
            assert "max_drops" in answer.result.message
            before = before or resident(node)
            del handle, number
        grown = resident(node) - before
        client.stop_spinning()
        action.destroy()
        return grown


def wait_in_line(domain, folder, requests, size, **values):
    """Send estimates of large new parts all at once; bytes by which the node grew at most.

    Returns
    -------
    grown : int
    answers : list
        Of the service.
    """
    with attacked(domain, folder, **values) as (node, client):
        client.good("estimate", part=large_part(size, "first"))
        before = resident(node)
        waiting = [client.send("estimate", part=large_part(size, f"part_{number}", 1.1))
                   for number in range(requests)]
        peak = before
        while not all(one.done() for one in waiting):
            peak = max(peak, resident(node))
            until(lambda: True)
        return peak - before, [one.result() for one in waiting]
