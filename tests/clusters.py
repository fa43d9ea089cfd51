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

"""A dask.distributed cluster of separate processes on this machine."""

import json
import os
import subprocess
import sys
import time
from contextlib import contextmanager

from tests.running import ROOT


@contextmanager
def dask(kind, *arguments, **environment):
    """A process of the cluster, killed in the end."""
    running = subprocess.Popen(
        [
            sys.executable,
            "-m",
            f"distributed.cli.dask_{kind}",
            *map(str, arguments),
            "--no-dashboard",
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        cwd=ROOT,
        env={**os.environ, **environment},
    )
    try:
        yield running
    finally:
        running.kill()
        running.wait()


@contextmanager
def scheduler(folder, **environment):
    """Its process and address."""
    scheduler_file = folder / "scheduler.json"
    with dask(
        "scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--scheduler-file",
        scheduler_file,
        **environment,
    ) as running:
        while not (
            scheduler_file.exists() and scheduler_file.read_text().endswith("}")
        ):  # it appears empty
            assert running.poll() is None
            time.sleep(0.05)
        yield running, json.loads(scheduler_file.read_text())["address"]


def worker(address):
    """A worker with one thread."""
    return dask("worker", address, "--nworkers", "1", "--nthreads", "1", "--no-nanny")
