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

"""The node `pose_stats`: its wiring, its start, and its end on SIGINT and SIGTERM."""

import ctypes
import gc
import sys
import threading
from collections.abc import Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor, wait
from contextlib import suppress
from typing import Any

import rclpy
from rclpy import exceptions, executors

from ..base.errors import PoseStatsError
from .answering_node import AnsweringNode
from .camera_counts import Cameras
from .equipment import Equipment
from .jobs import Jobs, job_reports, queue, refinement, run
from .lanes import Lane, Lanes, Rank
from .messages.times import follow_clock, steady_timer, watch_clock
from .participant import finish, join_ros
from .parts import intake, part_builder
from .parts.registry import PartRegistry
from .recorder import Recorder, convert_to_installed, definitions
from .refusals import COUNTS, Refusals, publish_diagnostics
from .services import feeding_plans, goals, plate_fits, services
from .settings import Settings
from .settings.parameters import Parameters
from .state import OF_PARTS, Change, State
from .stop_signals import StopSignals, finish_within, kill_after

REFUSED = 2
FAILED = 1
"""What the process ends with."""

THREADS = 16  # more than there are services, each of which may keep one waiting
SWITCH_SECONDS = 0.001  # threads that wait for the interpreter get it this soon
MENDING_SECONDS = 1.0  # for which a start waits for the bags of earlier runs
# for which the first client is let wait for parts whose scene is a new one
RESTORE_SECONDS = 1.5
END_SECONDS = 1.4  # jobs, goals and clients that wait are seen off in that time
LAST_SECONDS = 0.6  # of these, for refusals of requests that wait for their turn
QUIET_SECONDS = 0.1  # the node ends once nobody has been answered for so long
SAVE_SECONDS = (
    0.4  # to commit the state and finish the bag, where the rest took too long
)
MALLOC_ARENAS = -8  # M_ARENA_MAX of glibc's malloc.h
KILL_SECONDS = 10.0  # after which DDS is taken to have locked the interpreter


class PoseStatsNode(AnsweringNode):
    """Takes meshes and answers with statistics; computes nothing before `start`."""

    def __init__(self, **options: Any) -> None:
        super().__init__("pose_stats", **options)
        try:
            self._assemble()
        except BaseException:
            self.destroy_node()  # which others would see for a while
            raise

    def _assemble(self) -> None:
        """Make all that a node has, or refuse its parameters."""
        follow_clock(self.get_clock())
        watch_clock(self)
        self.table = Parameters(self, self._on_change)
        settings = self._settings
        log = self.get_logger()
        name = self.get_fully_qualified_name()
        # What the node keeps, and its bag.
        self.state = state = State(
            settings().state_path(name),
            definitions(),
            convert_to_installed,
            log.warning,
        )
        self.recorder = recorder = Recorder(settings(), name, state, log.warning)
        # What all others work with.
        self.lanes = lanes = Lanes(lambda: settings().max_mesh_bytes)
        refusals = Refusals(log.warning)
        equipment = Equipment(self, settings, state, recorder, refusals, lanes)
        # Parts and their results.
        self.builder = part_builder.PartBuilder(equipment)
        self.parts = parts = PartRegistry(equipment, self.builder)
        # Simulations. Goals may flip for minutes: plans do not wait for them.
        reports = job_reports.JobReports(equipment, parts)
        flips = run.FlipReports()
        plan_flips = run.FlipReports(flips.counted)
        prefix = recorder.log.directory.name.removeprefix("pose_stats_")
        self.jobs = jobs = Jobs(prefix, reports, log.error)
        self.flip_jobs = (
            Jobs(f"{prefix}_flips", flips, log.error, run.run_flips),
            Jobs(f"{prefix}_plans", plan_flips, log.error, run.run_flips),
        )
        refiner = refinement.Refinement(equipment, parts, jobs)
        # Meshes and cameras; nothing is heard before the executor has the node.
        self.intake = intake.Intake(equipment, parts, self.builder, refiner.follow)
        intake.subscribe_to_meshes(equipment, self.intake)
        self.cameras = Cameras(equipment, parts, self.intake.build_known)
        if settings().restore:
            parts.restore()
        else:
            removals = [
                Change(table, row[0], None)
                for table in OF_PARTS
                for row in state.rows(table)
            ]
            state.put(*removals)
        reports.restore()
        # Services and actions, what a feeder is to do, and plates.
        self.outlines = part_builder.Outlines(equipment)
        part_services = services.Services(
            equipment, parts, self.intake, refiner, jobs, reports, self.outlines
        )
        self.actions: list[goals.GoalServer[Any]] = [
            goals.SimulateDropsServer(equipment, part_services, jobs, reports),
            goals.SimulateFlipsServer(equipment, parts, self.intake, self.flip_jobs[0]),
            feeding_plans.PlanFeedingServer(
                equipment, parts, self.flip_jobs[1], flips, self.intake, self.outlines
            ),
        ]
        plate_fits.PlateFits(equipment, parts, self.table.use_plate)
        # Once a second: what was counted, the disk, and how the node is.
        steady_timer(self, 1.0, self._have_written_down)
        publish_diagnostics(
            self,
            {
                "parts": lambda: refusals.health(
                    len(parts.all()), lanes.count_meshes()
                ),
                "counts": parts.health_of_counts,
                "jobs": lambda: queue.job_health(jobs, settings()),
                "flips": lambda: queue.flip_health(*self.flip_jobs),
                "recording": lambda: recorder.health(refusals.lost[COUNTS]),
            },
        )

    def _settings(self) -> Settings:
        return self.table.settings

    def start(self) -> None:
        """Latch what an earlier run has latched, and begin to work, kernels loaded."""
        log = self.get_logger()
        parts = self.parts.all()
        for part in parts:
            part.restore()
        self.parts.listing.start()
        if parts:
            log.info(f"{len(parts)} parts of an earlier run are known again")
        finish_within(MENDING_SECONDS, self.recorder.mend_bags)
        self.lanes.start()
        self.intake.restore()

    def _on_change(self, settings: Settings) -> None:
        """Estimate known parts again, in the background."""
        self.parts.shrink()
        self.intake.show_all_again()

    def _have_written_down(self) -> None:
        """Wait until a lane has written down what is to be: that may need meshes.

        At the end of the node `close` does it.
        """
        task = self.lanes.put(self._write_down, Rank.WHEN_IDLE, Lane.RECORD)
        with suppress(CancelledError):
            task.result()

    def _write_down(self) -> None:
        """Once a second: show what was counted, and have all on the disk."""
        for part in self.parts.all():
            part.show_waiting()
        self.parts.store_uses()
        self.state.commit()
        self.recorder.sync()

    def close(self) -> None:
        """End jobs and goals, each within its time, and write all down."""
        self.builder.close()
        self.outlines.close()
        queues = (self.jobs, *self.flip_jobs)
        with ThreadPoolExecutor(1 + len(queues)) as pool:  # each may take its time
            ends = [pool.submit(self.lanes.close)]
            for jobs in queues:
                ends.append(pool.submit(jobs.close, "the node ended"))
        for end in ends:
            end.result()
        self.wait_until_quiet(
            QUIET_SECONDS,
            LAST_SECONDS,
            lambda: any(action.goals for action in self.actions),
        )
        self.cameras.take_last()
        self._write_down()
        self.save()

    def save(self) -> None:
        """Commit the state and finish the bag beside all else; may be called twice."""
        self.state.close()
        written = self.recorder.log.bytes_written
        self.recorder.close()
        if written:
            self.get_logger().info(f"recorded to {self.recorder.log.directory}")


def run_node(stop: StopSignals, arguments: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM, and then end the process with status 0.

    `arguments`: with `--ros-args`; default: the process's own. Ends with 1 after an
    internal failure; returns 2 for a refused parameter.
    """
    sys.setswitchinterval(SWITCH_SECONDS)
    _share_memory_between_threads()
    try:
        join_ros(arguments, "for instance --ros-args -p restitution:=0.3")
        node = None if stop.is_requested else PoseStatsNode()
    except (
        PoseStatsError,
        exceptions.InvalidParameterException,
        exceptions.InvalidParameterValueException,
        exceptions.NameValidationException,
    ) as refusal:
        print(f"pose_stats: {' '.join(str(refusal).split())}", file=sys.stderr)
        node = None
    if node is None:
        rclpy.try_shutdown()
        return 0 if stop.is_requested else REFUSED
    return Life(node, stop).run()


def _share_memory_between_threads() -> None:
    """Have what one thread frees serve the others, where the C library is glibc.

    It would give threads up to eight areas a core, each of which grows to its own peak.
    """
    set_option = getattr(ctypes.CDLL(None), "mallopt", None)
    if set_option is not None:
        set_option(MALLOC_ARENAS, 1)


class Life:
    """A node does all in threads for which its end waits for a while only."""

    def __init__(self, node: PoseStatsNode, stop: StopSignals) -> None:
        self._node = node
        self._stop = stop
        self._executor = executors.MultiThreadedExecutor(num_threads=THREADS)
        self._thread = threading.Thread(target=self._live, name="executor", daemon=True)
        self._failure: BaseException | None = None

    def run(self) -> int:
        """Live until the end is asked for, and end the process."""
        self._thread.start()
        self._stop.wait()
        kill_after(KILL_SECONDS)
        if not finish_within(END_SECONDS, self._end):
            finish_within(SAVE_SECONDS, self._node.save)
        if self._failure is not None:
            print(f"pose_stats: internal failure: {self._failure!r}", file=sys.stderr)
        # At a usual end Python would wait for every pool of threads.
        return finish(FAILED if self._failure else 0)

    def _live(self) -> None:
        """Load the kernels before anything is computed, and answer."""
        try:
            part_builder.warm_up(self._node.get_logger().info)
            if self._stop.is_requested:
                return
            self._node.start()
            # A collection of garbage keeps all threads waiting while it looks at what
            # is not frozen: modules and kernels alone take a tenth of a second.
            gc.collect()
            gc.freeze()
            wait(self._node.intake.restored, RESTORE_SECONDS)
            self._executor.add_node(self._node)
            self._executor.create_task(self._node.get_logger().info, "ready")
            self._spin()
        except BaseException as error:
            # Where an end is requested the executor has just been taken apart.
            if not self._stop.is_requested:
                self._failure = error
        finally:
            self._stop.request_end()

    def _spin(self) -> None:
        """Answer until the executor is shut down, whatever it lets through."""
        while True:
            try:
                self._executor.spin()
                return
            except Exception as error:  # for instance of what a client sent to rclpy
                # Where an end is requested the executor has just been taken apart.
                if not self._stop.is_requested:
                    self._node.get_logger().error(
                        "a callback failed, and the node goes on: "
                        f"{type(error).__name__}: {error}"
                    )

    def _end(self) -> None:
        """End what goes on, and leave ROS once nothing is called back any more."""
        self._node.close()
        self._executor.shutdown(timeout_sec=0.0)
        self._thread.join()
        # For its threads rclpy 7.1.6 does not wait.
        self._executor._executor.shutdown(wait=True)
        self._node.destroy_node()
        rclpy.try_shutdown()
