"""Answers of the action that are lost at first arrive all the same."""

from __future__ import annotations

import threading
import time
import warnings
from types import SimpleNamespace

import pytest
import rclpy
from rclpy.action import ActionClient, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from ros_pose_stats_msgs.action import SimulateDrops

from ros_pose_stats.ros.transport.late_answers import PatientActionServer, PatientNode

from ..harness.client import Client, until, wait_for

MISSED = 2
SUCCEEDED, CANCELED, UNKNOWN = 4, 5, 0


@pytest.fixture
def lossy(monkeypatch):
    """Has the first answers of a kind thrown away; how often each kind was sent."""
    sent = {}

    def lose(kind, missed=MISSED):
        name = f"send_{kind}_response"
        real = getattr(rclpy_implementation.ActionServer, name)
        sent[kind] = 0

        def send(handle, header, answer):
            sent[kind] += 1
            if sent[kind] <= missed:
                warnings.warn("failed to send response (timeout): not matched", RuntimeWarning,
                              stacklevel=1)
            else:
                real(handle, header, answer)

        monkeypatch.setattr(rclpy_implementation.ActionServer, name, send)

    return SimpleNamespace(lose=lose, sent=sent)


def drop(goal):
    """Succeeds at once, or runs until it is cancelled if there is something to drop."""
    while goal.request.drops and not goal.is_cancel_requested:
        time.sleep(0.01)
    if goal.request.drops:
        goal.canceled()
    else:
        goal.succeed()
    return SimulateDrops.Result(message="told")


@pytest.fixture
def actions(other_domain):
    """A client of a server without the rest of the node."""
    begun = []

    def begin(goal):
        begun.append(goal)
        goal.execute()

    context = rclpy.Context()
    rclpy.init(context=context, domain_id=other_domain)
    node = PatientNode("server", context=context)
    server = PatientActionServer(
        node, SimulateDrops, "~/simulate_drops", drop,
        goal_callback=lambda goal: (GoalResponse.REJECT if goal.part_id == "refused"
                                    else GoalResponse.ACCEPT),
        handle_accepted_callback=begin, cancel_callback=lambda goal: CancelResponse.ACCEPT,
        callback_group=ReentrantCallbackGroup())
    executor = MultiThreadedExecutor(num_threads=4, context=context)
    executor.add_node(node)
    spinning = threading.Thread(target=executor.spin)
    spinning.start()
    with Client(other_domain) as client:
        found = ActionClient(client.node, SimulateDrops, "/server/simulate_drops")
        until(found.server_is_ready, "the server")
        yield SimpleNamespace(
            send=lambda uuid=None, **fields: wait_for(client.run(
                lambda: found.send_goal_async(SimulateDrops.Goal(**fields), goal_uuid=uuid))),
            ask=client.run, begun=begun)
        client.stop_spinning()
        found.destroy()
    node.late_answers.close()
    executor.shutdown()
    spinning.join()
    server.destroy()
    node.destroy_node()
    context.try_shutdown()


def test_acceptance(actions, lossy):
    lossy.lose("goal")
    handle = actions.send()
    assert handle.accepted and lossy.sent == {"goal": MISSED + 1}
    assert handle.stamp == actions.begun[0]._goal_info.stamp
    answer = wait_for(actions.ask(handle.get_result_async))
    assert (answer.status, answer.result.message) == (SUCCEEDED, "told")


def test_rejection(actions, lossy):
    lossy.lose("goal")
    handle = actions.send(part_id="refused")
    assert not handle.accepted and handle.stamp.sec == 0
    assert lossy.sent == {"goal": MISSED + 1} and not actions.begun


def test_a_goal_that_comes_twice_is_rejected_the_second_time(actions, lossy):
    handle = actions.send(drops=1)
    lossy.lose("goal", missed=1)
    assert not actions.send(handle.goal_id, drops=1).accepted
    assert lossy.sent == {"goal": 2} and len(actions.begun) == 1
    wait_for(actions.ask(handle.cancel_goal_async))


def test_result(actions, lossy):
    lossy.lose("result")
    handle = actions.send()
    answer = wait_for(actions.ask(handle.get_result_async))
    assert (answer.status, answer.result.message) == (SUCCEEDED, "told")
    assert lossy.sent == {"result": MISSED + 1}


def test_result_of_an_unknown_goal(actions, lossy):
    lossy.lose("result")
    handle = actions.send()
    handle.goal_id.uuid[0] ^= 1
    assert wait_for(actions.ask(handle.get_result_async)).status == UNKNOWN
    assert lossy.sent == {"result": MISSED + 1}


def test_cancel(actions, lossy):
    lossy.lose("cancel")
    handle = actions.send(drops=1)
    result = actions.ask(handle.get_result_async)
    assert len(wait_for(actions.ask(handle.cancel_goal_async)).goals_canceling) == 1
    assert lossy.sent == {"cancel": MISSED + 1}
    assert wait_for(result).status == CANCELED
