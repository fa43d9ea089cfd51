"""Starts the node, and ends it on SIGINT and SIGTERM, whatever it does at that time."""

import os
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import wait

import rclpy
from rclpy import exceptions, executors, signals

from ..errors import PoseStatsError
from ..kernels.compilation import all_kernels, compile_missing, filling_store, prepare_kernels
from .node import PoseStatsNode
from .stop_signals import StopSignals

REFUSED = 2
FAILED = 1
THREADS = 8
RESTORE_SECONDS = 1.5  # the first client is let wait so long for parts whose scene is a new one
END_SECONDS = 1.4  # jobs, goals and clients that wait are seen off in that time
SAVE_SECONDS = 0.4  # to commit the state and finish the bag, where the rest took too long
SECONDS_BETWEEN = 5.0  # between lines of how many kernels are compiled
SWITCH_SECONDS = 0.001  # threads that wait for the interpreter get it this soon


def run_node(stop: StopSignals, arguments: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM, and then end the process with status 0.

    `arguments`: with `--ros-args`; default: the process's own. Ends with 1 after an internal
    failure; returns 2 for a refused parameter.
    """
    sys.setswitchinterval(SWITCH_SECONDS)
    try:
        rclpy.init(args=arguments, signal_handler_options=signals.SignalHandlerOptions.NO)
    except Exception as error:  # what rcl raises for arguments it cannot parse has no base
        print(f"pose_stats: {str(error).strip()}", file=sys.stderr)
        return REFUSED
    try:
        node = None if stop.asked else PoseStatsNode()
    except (PoseStatsError, exceptions.InvalidParameterException,
            exceptions.InvalidParameterValueException) as refusal:
        print(f"pose_stats: {refusal}", file=sys.stderr)
        node = None
    if node is None:
        rclpy.try_shutdown()
        return 0 if stop.asked else REFUSED
    return Life(node, stop).run()


class Life:
    """Everything that a node does is done in threads that the end does not wait for for long."""

    def __init__(self, node: PoseStatsNode, stop: StopSignals) -> None:
        self._node, self._stop = node, stop
        self._executor = executors.MultiThreadedExecutor(num_threads=THREADS)
        self._living = threading.Thread(target=self._live, name="executor", daemon=True)
        self._failure: BaseException | None = None

    def run(self) -> int:
        """Live until the end is asked for, and end the process."""
        self._living.start()
        self._stop.wait()
        if not _within(END_SECONDS, self._end):
            _within(SAVE_SECONDS, self._node.save)
        if self._failure is not None:
            print(f"pose_stats: internal failure: {self._failure!r}", file=sys.stderr)
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(FAILED if self._failure else 0)  # Python would wait for every pool of threads

    def _live(self) -> None:
        """Load the kernels before anything is computed, and answer."""
        try:
            warm_up(self._node.get_logger().info)
            if self._stop.asked:
                return
            self._node.start()
            wait(self._node.intake.restored, RESTORE_SECONDS)
            self._executor.add_node(self._node)
            self._executor.create_task(self._node.get_logger().info, "ready")
            self._executor.spin()
        except BaseException as error:
            if not self._stop.asked:  # else the executor has just been taken apart
                self._failure = error
        finally:
            self._stop.ask()

    def _end(self) -> None:
        """End what goes on, and leave ROS once nothing is called back any more."""
        self._node.close()
        self._executor.shutdown(timeout_sec=0.0)
        self._living.join()
        self._executor._executor.shutdown(wait=True)  # for which rclpy 7.1.6 does not wait
        self._node.destroy_node()
        rclpy.try_shutdown()


def _within(seconds: float, act: Callable[[], object]) -> bool:
    """Whether something is done within some seconds; if not it goes on, and nobody waits."""
    done = threading.Event()

    def do() -> None:
        act()
        done.set()

    doing = threading.Thread(target=do, name="end", daemon=True)
    doing.start()
    doing.join(seconds)
    return done.is_set()


def warm_up(say: Callable[..., object]) -> None:
    """Have the machine code of every kernel at hand; says if that takes a minute or more."""
    def fill() -> None:
        say("compiling kernels, once for all later starts; it takes a minute or two")
        compile_missing(lambda done, total: say(f"{done} of {total} kernels compiled",
                                                throttle_duration_sec=SECONDS_BETWEEN))

    all_kernels()
    with filling_store(fill):
        prepare_kernels()
