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

"""On PYTHONPATH, gives a process a clock that is wrong by the seconds in the file
TRIAL_CLOCK.
"""

import datetime
import os
import threading
import time
from pathlib import Path

FILE = Path(os.environ["TRIAL_CLOCK"])
GLANCE = 0.1
_time_ns = time.time_ns
_shift = int(1e9 * float(FILE.read_text("utf-8")))


def _shifted():
    return _time_ns() + _shift


def _follow():
    global _shift
    while True:
        _shift = int(1e9 * float(FILE.read_text("utf-8") or 0.0))
        time.sleep(GLANCE)


class ShiftedDatetime(datetime.datetime):
    """A date that follows the wrong clock."""

    @classmethod
    def now(cls, tz=None):
        """What the wrong clock shows."""
        return datetime.datetime.fromtimestamp(_shifted() / 1e9, tz)


time.time_ns = _shifted
datetime.datetime = ShiftedDatetime
threading.Thread(target=_follow, daemon=True).start()
