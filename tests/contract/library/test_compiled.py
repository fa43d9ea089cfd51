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

"""Kernels are compiled once: by `compile` all of them, else by the first that needs
one.
"""

import os
import subprocess
import sys
import time

import pytest

from tests.running import ROOT, call, children, is_gone

pytestmark = pytest.mark.long

FIRST_CALLS = """
import os, sys, threading
sys.setswitchinterval(1e-7)
from ros_pose_stats import part_from_mesh, simulate
from lab.bodies import shapes
part = part_from_mesh(*shapes.box(1.0, 2.0, 3.0))
together, refused = threading.Barrier(12), []
def drop():
    together.wait()
    try:
        simulate(part, drops=1, workers=1)
    except Exception as error:
        refused.append(error)
def first_calls():
    threads = [threading.Thread(target=drop) for _ in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return len(refused)
for _ in range(10):
    child = os.fork()
    if not child:
        os._exit(first_calls())
    if os.waitpid(child, 0)[1]:
        sys.exit("threads were refused")
"""


def started(*arguments, **environment):
    """A command in a process of its own."""
    outcome = subprocess.run(
        [sys.executable, "-m", "ros_pose_stats", *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        env=os.environ | environment,
    )
    assert outcome.returncode == 0, outcome.stderr
    return outcome


@pytest.fixture(scope="module")
def clamp(tmp_path_factory):
    folder = tmp_path_factory.mktemp("parts")
    assert call("shapes", folder).returncode == 0
    return folder / "clamp.stl"


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """A folder with all kernels."""
    store = tmp_path_factory.mktemp("store")
    cache = {"NUMBA_CACHE_DIR": str(store)}
    assert "kernels are in" in started("compile", **cache).stdout
    assert len(started("compile", **cache).stdout.splitlines()) == 1
    return store


def test_after_compile_no_command_compiles(clamp, store, tmp_path):
    cache = {"NUMBA_CACHE_DIR": str(store)}

    def kept():
        return {file: file.stat().st_mtime_ns for file in store.rglob("*")}

    kernels = kept()
    for name, *options in (
        ["estimate", "--method", "all"],
        ["estimate", "--target-error", "0.02"],
        ["simulate", "--drops", "100"],
        ["flips", "--kick", "0.03", "--flips", "100"],
        ["report", "--output", tmp_path / "page.html"],
        ["animate", "--output", tmp_path / "drop.gif"],
    ):
        outcome = started(name, clamp, "--unit", "mm", *options, **cache)
        assert "compiling" not in outcome.stdout + outcome.stderr
    assert kept() == kernels


def test_workers_end_with_a_command_that_is_killed(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-m", "ros_pose_stats", "compile"],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
    ) as command:
        while not list(tmp_path.rglob("*.code")):
            assert command.poll() is None
            time.sleep(0.01)
        workers = children(command.pid)
        command.kill()
    assert len(workers) > 1
    while not all(map(is_gone, workers)):
        time.sleep(0.01)


def test_damaged_kernels_cost_time_only(clamp, store):
    """Cut short or altered by a bit, as by a power cut."""
    request = "estimate", clamp, "--unit", "mm", "--method", "csae", "--json"
    cache = {"NUMBA_CACHE_DIR": str(store)}
    sound = started(*request, **cache).stdout
    for number, file in enumerate(sorted(store.rglob("*.code"))):
        data = file.read_bytes()
        file.write_bytes(data[:40] if number % 2 else data[:-1] + bytes([data[-1] ^ 1]))
    damaged = started(*request, **cache)
    assert damaged.stdout.partition('"seconds"')[0] == sound.partition('"seconds"')[0]
    assert "cannot be read" in damaged.stderr
    assert "cannot be read" not in started(*request, **cache).stderr


def test_where_nothing_can_be_kept_a_command_answers_all_the_same(clamp, tmp_path):
    (tmp_path / "file").write_text("in the way")
    cache = str(tmp_path / "file" / "cache")
    request = "estimate", clamp, "--unit", "mm", "--method", "csae", "--json"
    with_cache = started(*request).stdout
    uncached = started(
        *request,
        NUMBA_CACHE_DIR=cache,
        XDG_CACHE_HOME=cache,
        HOME=cache,
        TMPDIR=str(tmp_path),
    ).stdout
    assert uncached.partition('"seconds"')[0] == with_cache.partition('"seconds"')[0]


def test_threads_may_make_the_first_call_together():
    """Of ten processes, forked before any call; without locks each of them refused a
    thread.
    """
    outcome = subprocess.run(
        [sys.executable, "-c", FIRST_CALLS], cwd=ROOT, capture_output=True, text=True
    )
    assert outcome.returncode == 0, outcome.stderr
