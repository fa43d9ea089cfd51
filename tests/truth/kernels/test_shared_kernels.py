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

"""Compiled kernels beside an installation serve all users, where root has put them."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from ros_pose_stats.core.kernels import compilation
from tests.running import ROOT

pytestmark = pytest.mark.skipif(os.getuid() != 0, reason="only root gives files away")

NOBODY = 65534

LOOK = """
import json, os, sys, warnings
from ros_pose_stats.core.kernels import compilation
warnings.simplefilter("ignore")
kernel = min(compilation.all_kernels(), key=lambda kernel: kernel.name)
for user, path, owner, mode in json.loads(sys.argv[1]):
    before = os.stat(path)
    os.chown(path, owner, owner)
    os.chmod(path, mode)
    child = os.fork()
    if not child:
        os.setuid(user)
        os.write(1, f"{kernel.store()}\\n".encode())
        os._exit(0)
    os.waitpid(child, 0)
    os.chown(path, before.st_uid, before.st_gid)
    os.chmod(path, before.st_mode)
"""
"""For each case: what a path is made, and where a user finds a kernel then."""


def first_kernel():
    """By name, since the order of all hangs on what was imported before."""
    return min(compilation.all_kernels(), key=lambda kernel: kernel.name)


@pytest.fixture(scope="module")
def installation():
    """A copy of the package with all kernels beside it, which any user may enter."""
    kernel = first_kernel()
    kernel.prepare()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)
        shutil.copytree(ROOT / "ros_pose_stats", folder / "ros_pose_stats")
        cache = folder / "ros_pose_stats/__compiled__"
        shutil.rmtree(cache, ignore_errors=True)
        shutil.copytree(kernel.store(), cache / "ros_pose_stats" / kernel.store().name)
        yield folder


def run(installation, *words, cache=os.devnull):
    """A Python of that installation, which can keep nothing, unless in that cache."""
    caches = {
        **dict.fromkeys(("XDG_CACHE_HOME", "HOME"), os.devnull),
        "NUMBA_CACHE_DIR": str(cache),
    }
    return subprocess.run(
        [sys.executable, *words],
        cwd=installation,
        capture_output=True,
        text=True,
        env=os.environ | caches | {"PYTHONPATH": str(installation)},
    )


def places(installation, *cases, **options):
    """Where a kernel is found in each case; None where it is not."""
    outcome = run(installation, "-c", LOOK, json.dumps(cases), **options)
    assert outcome.returncode == 0, outcome.stderr
    return outcome.stdout.split()


def test_what_root_has_put_there_is_used_and_nothing_else(installation):
    cache = installation / "ros_pose_stats/__compiled__"
    (store,) = (cache / "ros_pose_stats").iterdir()
    (target,) = store.iterdir()
    kernel = first_kernel()
    (file,) = target.glob(f"*.{kernel.name}.code")
    for path in (cache, *cache.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)
    # The last is the folder that the installation is in.
    way = list(map(str, (file, target, store, *store.parents[:4])))
    used = [
        (0, str(file), 0, 0o444),
        (NOBODY, str(file), 0, 0o444),
        (NOBODY, way[-1], 0, 0o1777),
        (NOBODY, str(store), NOBODY, 0o755),
    ]
    unused = [
        *((0, path, NOBODY, 0o755) for path in way),
        *((NOBODY, path, NOBODY - 1, 0o755) for path in way),
        *((NOBODY, path, 0, 0o777) for path in way),
        (0, str(file), 0, 0o666),
    ]
    assert places(installation, *used, *unused) == (
        [str(store)] * len(used) + ["None"] * len(unused)
    )
    assert places(ROOT, *used, cache=cache) == [str(store)] * len(used)


@pytest.mark.long
def test_compile_keeps_kernels_for_everybody_where_nobody_else_can_write(installation):
    package = "-m", "ros_pose_stats"
    cache = installation / "ros_pose_stats/__compiled__"
    for path in (cache, *cache.rglob("*")):
        path.chmod(0o700 if path.is_dir() else 0o600)  # as one's own cache is
    compiled = run(installation, *package, "compile", "--system")
    assert compiled.returncode == 0 and str(cache) in compiled.stdout
    run(installation, *package, "shapes", ".")
    estimate = "estimate", "clamp.stl", "--unit", "mm", "--method", "csae"
    answer = run(installation, *package, *estimate)
    assert answer.returncode == 0 and answer.stderr == ""
    modes = {oct(path.stat().st_mode & 0o777) for path in cache.rglob("*")}
    assert modes == {"0o755", "0o644"}
    installation.chmod(0o777)
    refused = run(installation, *package, "compile", "--system")
    (line,) = refused.stderr.splitlines()
    assert refused.returncode == 2
    assert f"{installation} (others can write there)" in line and "chmod" in line
