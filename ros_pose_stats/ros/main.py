"""Starts the node, and ends it cleanly on SIGINT and SIGTERM."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Sequence

import rclpy
from rclpy.exceptions import InvalidParameterException, InvalidParameterValueException
from rclpy.executors import MultiThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from ..errors import PoseStatsError
from ..kernels.compilation import all_kernels, prepare_kernels, watch_compilations
from .messages.times import steady_timer
from .node import PoseStatsNode
from .stop_signals import StopSignals

REFUSED = 2
FAILED = 1
THREADS = 8
RESTORE_SECONDS = 10.0
GLANCE_SECONDS = 0.05
LAST_SECONDS = 0.5
"""What callbacks have begun may be finished for so long."""

SWITCH_SECONDS = 0.001
"""Threads that wait for the interpreter get it this soon."""


def run_node(stop: StopSignals, arguments: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM.

    `stop`: made before ROS was imported, which takes a second; `arguments`: with `--ros-args`;
    default: the process's own. Returns 0; 2 for a refused parameter; 1 for an internal failure.
    """
    sys.setswitchinterval(SWITCH_SECONDS)
    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # what rcl raises for arguments it cannot parse has no base
        print(f"pose_stats: {str(error).strip()}", file=sys.stderr)
        return REFUSED
    try:
        return _run(stop)
    finally:
        rclpy.try_shutdown()


def _run(stop: StopSignals) -> int:
    executor = MultiThreadedExecutor(num_threads=THREADS)
    if stop.asked:
        return 0
    try:
        node = PoseStatsNode()
    except (PoseStatsError, InvalidParameterException, InvalidParameterValueException) as refusal:
        print(f"pose_stats: {refusal}", file=sys.stderr)
        return REFUSED
    if not stop.asked:
        warm_up(node.get_logger().info)
        _restore(node, stop)
    executor.add_node(node)
    failure: list[BaseException] = []
    spinning = threading.Thread(target=_spin, args=(executor, failure, stop), name="executor")
    _say_ready(node)
    spinning.start()
    at_rest = False
    try:
        stop.wait()
    finally:
        at_rest = node.close()
        at_rest = executor.shutdown(timeout_sec=LAST_SECONDS) and at_rest
        spinning.join(timeout=LAST_SECONDS)
        if at_rest:
            node.destroy_node()
    if failure:
        print(f"pose_stats: internal failure: {failure[0]!r}", file=sys.stderr)
    status = FAILED if failure else 0
    if not at_rest:
        _end_at_once(status)
    return status


def _end_at_once(status: int) -> None:
    """End although a thread still computes, which Python would wait for."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def warm_up(say: Callable[[str], object]) -> None:
    """Have the machine code of every kernel at hand before the first client comes.

    `say`: told if kernels are compiled, which takes a minute or more.
    """
    begin = time.monotonic()
    compiled: list[str] = []

    def tell(kernel: str) -> None:
        if not compiled:
            say("compiling kernels, which takes a minute or more; `ros_pose_stats compile` does "
                "so once for all later starts")
        compiled.append(kernel)

    all_kernels()
    with watch_compilations(tell):
        prepare_kernels()
    if compiled:
        say(f"{len(compiled)} kernels compiled in {time.monotonic() - begin:.0f} s")


def _restore(node: PoseStatsNode, stop: StopSignals) -> None:
    """Wait a while for the parts of the last run, so that the first client finds them."""
    until = time.monotonic() + RESTORE_SECONDS
    while not stop.asked and not node.restored(GLANCE_SECONDS) and time.monotonic() < until:
        pass


def _spin(executor: MultiThreadedExecutor, failure: list[BaseException],
          stop: StopSignals) -> None:
    try:
        executor.spin()
    except BaseException as error:
        if not stop.asked:  # else the main thread has just taken the executor apart
            failure.append(error)  # told by the main thread
            stop.ask()


def _say_ready(node: PoseStatsNode) -> None:
    """Have the executor say once that it answers."""
    def say() -> None:
        timer.cancel()
        node.get_logger().info("ready")

    timer = steady_timer(node, 0.001, say)
