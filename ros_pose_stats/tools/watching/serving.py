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
