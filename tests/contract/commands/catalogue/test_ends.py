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

"""A catalogue is the same however often its run is stopped, killed or out of room."""

import os
import pty
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from typing import NamedTuple

import pytest

from tests.running import ROOT, call, children, complaints, is_gone, refusal

from .parts import ASKED, PARTS, REFUSED, TABLES, set_parts, tables

PATIENCE = 60.0


class Run:
    """The command in a process of its own, watched on a terminal, which has time for
    that.
    """

    def __init__(self, *options, **environment):
        self.terminal, stderr = pty.openpty()
        self.process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "ros_pose_stats",
                *map(str, ASKED),
                "-o",
                "stopped",
                *options,
            ],
            stdout=subprocess.PIPE,
            stderr=stderr,
            text=True,
            start_new_session=True,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            preexec_fn=lambda: os.nice(5),
            **environment,
        )
        os.close(stderr)

    def wait_for(self, condition):
        """Until the bar shows more parts than so many; returns how many."""
        while True:
            printed = os.read(self.terminal, 4096).decode()
            counts = [
                int(count) for count in re.findall(r"(\d+) of \d+ parts", printed)
            ]
            if counts and counts[-1] > condition:
                return counts[-1]

    def end(self):
        """Standard output, once it has ended."""
        printed, _ = self.process.communicate(timeout=PATIENCE)
        os.close(self.terminal)
        return printed


def are_gone(processes):
    deadline = time.monotonic() + PATIENCE
    while not all(map(is_gone, processes)):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True


class Ended(NamedTuple):
    """What came of a run on a full disk, one that was killed, one with Ctrl-C, and the
    last.
    """

    full: tuple
    killed: bool
    in_use: str
    stopped: tuple
    page: str
    last: str


@pytest.fixture(scope="module")
def ended(home):
    """One catalogue that four runs make, of files that change on the way."""
    set_parts(home / "parts", late=False)
    full = subprocess.run(
        [sys.executable, "-m", "ros_pose_stats", *map(str, ASKED), "-o", "stopped"],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, 30_000)),
    )
    begun = Run()
    while not children(begun.process.pid):
        assert begun.process.poll() is None
    os.killpg(begun.process.pid, signal.SIGINT)  # also to those that just start
    assert "interrupted" in begun.end() and begun.process.returncode == 130
    first = Run()
    first.wait_for(0)
    workers = children(first.process.pid)
    first.process.kill()
    first.end()
    killed = bool(workers) and are_gone(workers)
    set_parts(home / "parts", late=True)
    second = Run()
    count = second.wait_for(0)
    os.kill(second.process.pid, signal.SIGSTOP)
    os.kill(min(children(second.process.pid)), signal.SIGKILL)
    in_use = refusal(*ASKED, "-o", "stopped")
    os.kill(second.process.pid, signal.SIGCONT)
    second.wait_for(max(count, len(REFUSED) + 1))  # refused ones are looked at again
    os.killpg(second.process.pid, signal.SIGINT)  # as a terminal sends it
    stopped = second.end(), second.process.returncode
    page = (home / "stopped" / "index.html").read_text(encoding="utf-8")
    last = call(*ASKED, "-o", "stopped")
    assert (last.returncode, complaints(last.stderr)) == (0, [])
    return Ended(
        (full.returncode, full.stderr), killed, in_use, stopped, page, last.stdout
    )


@pytest.mark.long
class TestEnds:
    def test_a_full_disk_is_said_in_one_line(self, ended):
        status, error = ended.full
        (line,) = complaints(error)
        assert (
            status == 2
            and "parts.sqlite3 (disk I/O error)" in line
            and "make room" in line
        )

    def test_rows_that_cannot_be_read_are_refused_with_what_to_do(
        self, home, catalogue
    ):
        shutil.copytree(catalogue[1], home / "damaged")
        (home / "damaged" / "parts.sqlite3").write_bytes(b"no rows" * 1000)
        assert "delete it" in refusal(*ASKED, "-o", "damaged")

    def test_a_killed_run_leaves_no_process(self, ended):
        assert ended.killed

    def test_two_runs_at_once_are_refused(self, ended):
        assert "in use" in ended.in_use

    def test_ctrl_c_says_how_to_go_on_and_the_page_that_it_is_not_whole(
        self, home, ended
    ):
        text, status = ended.stopped
        assert (
            status == 130
            and "the same command goes on from here" in text.splitlines()[-1]
        )
        assert "not the whole catalogue" in ended.page
        assert (
            "not the whole catalogue"
            not in (home / "stopped" / "index.html").read_text()
        )

    def test_the_tables_are_those_of_one_go_and_nothing_was_done_twice(
        self, home, ended, catalogue
    ):
        """Of files as they are in the end; what the runs before did was kept."""
        assert tables(home / "stopped") == tables(catalogue[1])
        assert int(re.search(r", (\d+) of them done before", ended.last)[1]) > 0

    def test_words_say_what_was_written_and_refused(self, ended):
        first, *files, last = ended.last.splitlines()
        assert first.startswith(f"stopped/index.html: {PARTS} parts, ")
        assert f" {len(REFUSED) + 1} refused, took " in first
        assert files[:2] == [f"stopped/{name}" for name in TABLES]
        assert sum(line.startswith("refused ") for line in files) == 10
        assert last == "and 2 more, with reasons in the table"

    def test_no_name_reaches_the_terminal_as_a_command(self, ended):
        assert "\x1b" not in ended.last and "refused parts/?[31mred.stl: " in ended.last
