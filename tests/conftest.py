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

"""Settings of the whole suite: equal examples in every run, time limits, processes
counted.

`HYPOTHESIS_PROFILE=search pytest ...` tries many more examples, different in every run.
At its end a run says how many processes its tests started, and lists them in the file
`STARTS_LOG`; a whole quick run of up to three workers, who have a node each, fails at
more than `MOST_STARTS`.
"""

import faulthandler
import gc
import os
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

COMMON = {
    "deadline": None,
    "database": None,
    "print_blob": True,
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large],
}
settings.register_profile("fixed", derandomize=True, max_examples=60, **COMMON)
settings.register_profile("search", max_examples=3000, **COMMON)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fixed"))

MOST_STARTS = 80
FEW_WORKERS = 3
LONG_SECONDS = 1800
NODE_SECONDS = 600
"""Time limits of long tests and of those over DDS; that of the others is in
`pytest.ini`.
"""

OVERTIME_SECONDS = 300
"""For what a test that has reached its limit must end, such as nodes."""

END_SECONDS = 120
"""In which Python must have ended after the last test."""

STARTS = "process_starts"

TOGETHER = ("contract/pages/", "contract/node/parts/", "contract/node/")
"""Folders, from that of `pytest.ini`, whose files share what takes seconds to make:
pages and a browser; two nodes. What waits for nodes is left to two workers, so that
another one always computes. Many workers would wait for those two.
"""


def _is_light(details):
    """Whether a process is one of Python's platform, or reads a file without numpy."""
    words = details[1] if isinstance(details[1], list) else []
    name = words[0] if words else details[0]
    return name == "uname" or words[1:3] == ["-I", "-S"]


class StartCount:
    """Processes started by the tests of this worker, or of all of them."""

    def __init__(self):
        self.starts = 0

    def hear(self, event, details):
        """Called by Python for every audited event."""
        if event == "subprocess.Popen" and not _is_light(details):
            self.starts += 1
            if "STARTS_LOG" in os.environ:
                with Path(os.environ["STARTS_LOG"]).open("a", encoding="utf-8") as log:
                    print(os.environ.get("PYTEST_CURRENT_TEST"), details[1], file=log)


COUNT = StartCount()


def pytest_configure(config):
    config.stash[COUNT_KEY] = 0
    config.stash[ERROR_KEY] = os.dup(2)  # before it is captured
    if hasattr(config, "workerinput") or not config.getoption("numprocesses", None):
        sys.addaudithook(COUNT.hear)


COUNT_KEY = pytest.StashKey()
ERROR_KEY = pytest.StashKey()


def pytest_collection_modifyitems(items):
    for item in items:
        marks = {mark.name for mark in item.iter_markers()}
        if "timeout" not in marks and (
            "long" in marks or "domain" in item.fixturenames
        ):
            item.add_marker(
                pytest.mark.timeout(LONG_SECONDS if "long" in marks else NODE_SECONDS)
            )


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Files to workers; few workers get those of a folder of `TOGETHER` at once."""
    if (
        config.getoption("dist") != "loadfile"
        or (config.option.numprocesses or 1) > FEW_WORKERS
    ):
        return None
    from xdist.scheduler import LoadFileScheduling

    class LoadRoomScheduling(LoadFileScheduling):
        def _split_scope(self, nodeid):
            file = super()._split_scope(nodeid)
            return next(filter(file.startswith, TOGETHER), file)

    return LoadRoomScheduling(config, log)


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Import without garbage collection, and leave out of it what stays to the end."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """End the process with a trace where a test goes on long after its limit.

    Machine code that keeps the interpreter lets no signal be heard, and needs another
    thread of machine code to be ended.
    """
    mark = item.get_closest_marker("timeout")
    limit = mark.args[0] if mark else float(item.config.getini("timeout"))
    exit_after(limit + OVERTIME_SECONDS, item.config)
    try:
        return (yield)
    finally:
        faulthandler.cancel_dump_traceback_later()


def pytest_unconfigure(config):
    # A worker without further tests waits for those of others as long as they take.
    if not hasattr(config, "workerinput"):
        exit_after(END_SECONDS, config)


def exit_after(seconds, config):
    faulthandler.dump_traceback_later(seconds, file=config.stash[ERROR_KEY], exit=True)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node, error):
    """Add what a worker counted that has ended."""
    node.config.stash[COUNT_KEY] += getattr(node, "workeroutput", {}).get(STARTS, 0)


def pytest_sessionfinish(session):
    config = session.config
    if hasattr(config, "workeroutput"):
        config.workeroutput[STARTS] = COUNT.starts
        return
    config.stash[COUNT_KEY] += COUNT.starts
    whole = config.option.markexpr == "not long" and config.args == ["tests"]
    if (
        whole
        and (config.option.numprocesses or 1) <= FEW_WORKERS
        and config.stash[COUNT_KEY] > MOST_STARTS
    ):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter, config):
    terminalreporter.write_line(
        f"{config.stash[COUNT_KEY]} processes started by tests, {MOST_STARTS} allowed"
    )
