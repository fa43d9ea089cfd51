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

"""SIGINT and SIGTERM as a wish to end, from before ROS is imported."""

import signal
import threading
import time
from collections.abc import Callable

GLANCE_SECONDS = 0.05  # within which a wish is seen


class StopSignals:
    """Takes the place of what SIGINT and SIGTERM do by default."""

    def __init__(self) -> None:
        self.is_requested = False  # whether the process is to end
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda number, frame: self.request_end())

    def request_end(self) -> None:
        """Ask for the end, from any thread."""
        self.is_requested = True

    def wait(self) -> None:
        """Return as soon as the end is asked for.

        No ``threading.Event``: a handler runs in the thread that waits, maybe in the
        middle of ``Event.wait`` while that holds the lock for which ``Event.set`` then
        waits for ever.
        """
        while not self.is_requested:
            time.sleep(GLANCE_SECONDS)


def finish_within(seconds: float, act: Callable[[], object]) -> bool:
    """Whether something ends within some seconds; if not it goes on by itself."""
    finished = threading.Event()

    def do() -> None:
        act()
        finished.set()

    thread = threading.Thread(target=do, name="end", daemon=True)
    thread.start()
    thread.join(seconds)
    return finished.is_set()


def kill_after(seconds: float) -> None:
    """Have the process killed by SIGALRM, which needs no interpreter; 0 calls that off.

    What a node has in DDS may never end, with the interpreter locked. Where the signal
    is somebody else's already, nothing is done.
    """
    if signal.getsignal(signal.SIGALRM) is signal.SIG_DFL:
        signal.setitimer(signal.ITIMER_REAL, seconds)
