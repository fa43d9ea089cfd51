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

"""Hears of latched results as bytes: it takes little time itself."""

import threading
from collections import deque

from ros_pose_stats_msgs.msg import PoseStatistics

PATIENCE = 60.0
"""Seconds after which a result counts as missing."""


class Listener:
    """What has been latched since `forget`, the newest hundred results."""

    def __init__(self, client):
        self._news = threading.Condition()
        self._results = deque(maxlen=100)
        topic = f"{client.prefix}/pose_statistics"
        client.subscribe(PoseStatistics, topic, self._take, latched=True, raw=True)

    def _take(self, result):
        with self._news:
            self._results.append(result)
            self._news.notify_all()

    def forget(self):
        """Begin anew."""
        with self._news:
            self._results.clear()

    def wait(self, text):
        """Wait for a result with that name or digest in it."""
        needle = text.encode()

        def is_there():
            return any(needle in result for result in self._results)

        with self._news:
            if not self._news.wait_for(is_there, PATIENCE):
                raise TimeoutError(f"no result of {text} within {PATIENCE:.0f} s")
