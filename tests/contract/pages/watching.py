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

"""`report --watch` as a process, and what a browser would ask it."""

import http.client
import json
import re
import signal
import subprocess
import sys
from typing import NamedTuple
from urllib.parse import urlsplit

from tests.running import ROOT


class Reply(NamedTuple):
    """What the server answered."""

    status: int
    headers: http.client.HTTPMessage
    content: str


class WatchingCommand:
    """A command that follows a file until it is closed.

    Attributes
    ----------
    address : str
        Of the page, as the command prints it.
    port : int
    path : str
        Of the page; the token is in it.
    first_lines : list of str
        What it prints before the address.
    """

    def __init__(self, file, *options):
        self.process = subprocess.Popen(
            [
                *(sys.executable, "-m", "ros_pose_stats", "report", str(file)),
                *("--unit", "mm", "--watch", "--no-browser", *map(str, options)),
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )
        self.first_lines = []
        line = self.line()
        while "http://" not in line:
            self.first_lines.append(line)
            line = self.line()
        self.address = re.search(r"http://\S+/", line)[0]
        parts = urlsplit(self.address)
        self.port = parts.port
        self.path = parts.path

    def line(self):
        """The next line of the terminal."""
        line = self.process.stdout.readline()
        if not line:
            raise AssertionError(f"it has ended: {self.process.stderr.read()}")
        return line.rstrip()

    def ask(self, name="", method="GET", path=None, **headers):
        """Ask for a file of the page, or for another path."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port)
        try:
            path = f"{self.path}{name}" if path is None else path
            connection.request(method, path, headers=headers)
            answer = connection.getresponse()
            return Reply(answer.status, answer.headers, answer.read().decode())
        finally:
            connection.close()

    def news(self, after=-1, version=-1):
        """News after some number, once there are any."""
        while True:
            reply = self.ask(f"news?after={after}&version={version}")
            assert reply.status in (200, 204)
            if reply.status == 200:
                return json.loads(reply.content)

    def news_with(self, words):
        """The first news that say some words."""
        news = self.news()
        while words not in news["html"]:
            news = self.news(news["number"], news["version"])
        return news

    def end(self, number=signal.SIGTERM):
        """End it by a signal; its exit status, and what it complained of."""
        self.process.send_signal(number)
        _, complaints = self.process.communicate()
        return self.process.returncode, complaints
