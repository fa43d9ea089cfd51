"""Calls as soon as a service is there, on a starved machine: how many are never answered.

    python -m lab.trials.first_calls [--calls 1000] [--busy 4]

A client may know a node before the node knows the client; rclpy then throws the answer away with a
warning. Each call is that of a client that has just been made. `eager` looks for the service a
thousand times a second, calls once and waits; `wait_for_service` is rclpy's own way of waiting;
`again` waits that way and calls again each second, as the documentation has it. The server is a
plain rclpy node, and the node class of `pose_stats`, with one service each.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor

import rclpy
from domain_coordinator import domain_id
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from ros_pose_stats_msgs.srv import CancelDropSimulation

from . import ROOT

SERVICE = "/first_calls/service"
PATIENCE = 12.0
TIMEOUT = 1.0
AT_ONCE = 6
WAYS = ("eager", "wait_for_service", "again")
BUSY = "while True: sum(range(100_000))"


def serve(kind: str) -> None:
    """Answer until standard input ends."""
    from ros_pose_stats.node.answering_node import AnsweringNode

    rclpy.init()
    if kind == "node":
        node = AnsweringNode("first_calls")
        node.serve(CancelDropSimulation, SERVICE, lambda request, response: None)
    else:
        warnings.filterwarnings("ignore", message="failed to send response")
        node = rclpy.create_node("first_calls")
        node.create_service(
            CancelDropSimulation, SERVICE, lambda request, response: response
        )
    executor = MultiThreadedExecutor(8)
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    print("ready", flush=True)
    sys.stdin.read()
    os._exit(0)


def first_call(way: str) -> float:
    """Seconds until the answer to the call of a new client; infinity where none comes."""
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("client", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    client = node.create_client(CancelDropSimulation, SERVICE)
    try:
        if way == "eager":
            while not client.service_is_ready():
                time.sleep(0.001)
        else:
            while not client.wait_for_service(5.0):
                pass
        begin = time.monotonic()
        while time.monotonic() - begin < PATIENCE:
            coming = client.call_async(CancelDropSimulation.Request())
            executor.spin_until_future_complete(
                coming, TIMEOUT if way == "again" else PATIENCE
            )
            if coming.done():
                return time.monotonic() - begin
            client.remove_pending_request(coming)
            if way != "again":
                break
        return float("inf")
    finally:
        executor.shutdown()
        node.destroy_node()
        context.try_shutdown()


def main() -> None:
    """Measure both servers and all ways of calling, and print a row each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--calls", type=int, default=1000)
    parser.add_argument(
        "--busy", type=int, default=4, help="processes that only compute"
    )
    parser.add_argument("--serve", choices=("plain", "node"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        return serve(options.serve)
    with domain_id() as number:
        os.environ["ROS_DOMAIN_ID"] = str(number)
        busy = [
            subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(options.busy)
        ]
        try:
            for kind in ("plain", "node"):
                server = subprocess.Popen(
                    [sys.executable, "-m", "lab.trials.first_calls", "--serve", kind],
                    cwd=ROOT,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    text=True,
                )
                assert server.stdout is not None
                server.stdout.readline()
                for way in WAYS:
                    with ThreadPoolExecutor(AT_ONCE) as pool:
                        seconds = sorted(
                            pool.map(
                                lambda _, way=way: first_call(way), range(options.calls)
                            )
                        )
                    never = sum(one == float("inf") for one in seconds)
                    slow = sum(one > TIMEOUT for one in seconds) - never
                    print(
                        f"{kind:6} {way:17} {never} of {options.calls} never answered, {slow} "
                        f"after more than {TIMEOUT:g} s; median "
                        f"{1e3 * seconds[len(seconds) // 2]:.0f} ms, last "
                        f"{seconds[-1 - never]:.2f} s",
                        flush=True,
                    )
                server.kill()
                server.wait()
        finally:
            for one in busy:
                one.kill()
    return None


if __name__ == "__main__":
    main()
