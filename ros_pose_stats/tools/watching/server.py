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

"""A server for the browsers of this machine: a page, its script, and its news.

It listens on 127.0.0.1 alone. Whoever asks must know a random token, which is in the
path, and must name this address as the host: a page of another site, whose name was
bound to 127.0.0.1 afterwards, names its own. Nothing can be sent to it.
"""

import hmac
import secrets
import select
import socketserver
import threading
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, urlsplit

from ...base.errors import RequestError
from .news import NewsBoard

ADDRESS = "127.0.0.1"
MOST_PORT = 65_535
MOST_CLIENTS = 16  # answered at a time
WAITS = 10  # of a second for news, before the page asks again
SLOW_SECONDS = 15.0  # in which a client must have asked, and taken its answer

HEADERS = {
    "Content-Security-Policy": "default-src 'none'; img-src data:; "
    "style-src 'unsafe-inline'; script-src 'self'; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Of every answer. The page loads nothing but its own script and news, and no page of
another site may show or read it."""


class PageServer(ThreadingHTTPServer):
    """Serves a page that follows its news.

    Parameters
    ----------
    port : int
        0 for any that is free.
    page, script : str
        HTML and JavaScript.
    board : NewsBoard

    Raises
    ------
    RequestError
        If the port is out of its range or taken.
    """

    daemon_threads = True
    block_on_close = False

    def __init__(self, port: int, page: str, script: str, board: NewsBoard) -> None:
        self.board = board
        self.files = {
            "": ("text/html; charset=utf-8", page.encode(errors="replace")),
            "script.js": ("text/javascript; charset=utf-8", script.encode()),
        }
        self._free_clients = threading.BoundedSemaphore(MOST_CLIENTS)
        if not 0 <= port <= MOST_PORT:
            raise RequestError(
                f"a port from 0 to {MOST_PORT}", f"{port}", "0 takes any that is free"
            )
        try:
            super().__init__((ADDRESS, port), _Handler)
        except OSError as error:
            raise RequestError(
                "a port that is free",
                f"{port}: {error.strerror}",
                "leave it out to take any",
            ) from error
        self.hosts = tuple(
            f"{name}:{self.server_port}" for name in (ADDRESS, "localhost")
        )
        self.token = secrets.token_urlsafe(24)

    @property
    def address(self) -> str:
        """Where a browser finds the page."""
        return f"http://{ADDRESS}:{self.server_port}/{self.token}/"

    def server_bind(self) -> None:
        """Bind, without a question about names to the network."""
        socketserver.TCPServer.server_bind(self)
        self.server_name = ADDRESS
        self.server_port = self.server_address[1]

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer in a thread of its own; one too many is sent away."""
        if self._free_clients.acquire(blocking=False):
            super().process_request(request, client_address)
            return
        request.settimeout(0.1)
        with suppress(OSError):
            request.sendall(b"HTTP/1.0 503 Service Unavailable\r\n\r\n")
        self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Answer, and make room for the next."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free_clients.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of a browser that closed its page in the middle of an answer."""


class _Handler(BaseHTTPRequestHandler):
    """One request; the base class refuses all but GET."""

    server: PageServer
    timeout = SLOW_SECONDS
    error_message_format = "%(message)s\n"
    error_content_type = "text/plain"

    def do_GET(self) -> None:
        """Answer the page, its script or its news to those who may have them."""
        address = urlsplit(self.path)
        token, _, name = address.path.removeprefix("/").partition("/")
        hosts = self.headers.get_all("Host", [])
        if len(hosts) != 1 or hosts[0].lower() not in self.server.hosts:
            self.send_error(HTTPStatus.FORBIDDEN)
        elif not hmac.compare_digest(token.encode(), self.server.token.encode()):
            self.send_error(HTTPStatus.NOT_FOUND)
        elif name in self.server.files:
            self._send(*self.server.files[name])
        elif name == "news":
            self._send_news(parse_qs(address.query))
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def _send_news(self, question: dict[str, list[str]]) -> None:
        """Wait for news after those that the page has, and send them."""
        try:
            number, version = (
                int(question.get(name, ["-1"])[0]) for name in ("after", "version")
            )
        except ValueError:
            self.send_error(HTTPStatus.BAD_REQUEST)
            return
        news = None
        for _ in range(WAITS):
            news = self.server.board.wait(number, 1.0)
            if news is not None or self._is_closed():
                break
        if news is None:
            self.send_response(HTTPStatus.NO_CONTENT)
            self.end_headers()
            return
        self._send("application/json", news.as_json(version))

    def _is_closed(self) -> bool:
        """Whether the browser waits no more; it sends nothing behind its question."""
        return bool(select.select([self.connection], [], [], 0.0)[0])

    def _send(self, kind: str, content: bytes) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def end_headers(self) -> None:
        """Send what every answer says to the browser."""
        for name, value in HEADERS.items():
            self.send_header(name, value)
        super().end_headers()

    def version_string(self) -> str:
        """The name of the server, and no versions."""
        return "ros_pose_stats"

    def log_message(self, *_: Any) -> None:
        """Print nothing: the terminal has a line for each version."""
