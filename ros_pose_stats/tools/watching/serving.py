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

"""The server and the session side by side, until a signal ends both."""

import os
import signal
import sys
import threading

from .server import PageServer
from .session import Session

POLL_SECONDS = 0.1
END_SECONDS = 0.5  # for the work at hand; a STEP file may take longer to read


def serve(server: PageServer, session: Session) -> None:
    """Serve the page and follow the file until SIGINT or SIGTERM.

    The main thread waits for signals alone: it hears them at once, whatever the session
    computes.
    """
    signals: list[int] = []
    failures: list[BaseException] = []

    def follow() -> None:
        try:
            session.run(lambda: bool(signals))
        except BaseException as failure:
            failures.append(failure)

    handlers = {
        number: signal.signal(number, lambda received, _: signals.append(received))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    follower = threading.Thread(target=follow, daemon=True)
    listener = threading.Thread(
        target=server.serve_forever, args=(POLL_SECONDS,), daemon=True
    )
    try:
        listener.start()
        follower.start()
        while follower.is_alive() and not signals:
            follower.join(POLL_SECONDS)
    finally:
        server.board.close()
        server.shutdown()
        follower.join(END_SECONDS)
        for number, handler in handlers.items():
            signal.signal(number, handler)
    if follower.is_alive():
        sys.stdout.flush()
        os._exit(0)
    if failures:
        raise failures[0]
