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

"""Time of whole processes: `python -m lab.benchmarks.start [--write]`."""

import os
import resource
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from statistics import median

from lab.frame.page import ROOT
from lab.frame.results import Row, Section, Target
from lab.frame.timing import Contender, Pace, Timings, race
from ros_pose_stats.core.shapes.demo_parts import write_demo_parts

from .program import benchmark_parser, run_benchmark

FIRST = 1.5
LIMIT = 1.2
AIM = 0.5
DROPS = 1.2
"""Limits in seconds: the first command after set-up, a warm one, its aim in processor
time, one with 1000 drops.
"""
COMPILE_CPU = 60.0
COMPILE_WALL = 35.0

RUNS = 9
"""Warm processes of each kind."""

COMMAND = "ros_pose_stats estimate clamp.stl --unit mm"
DROPPING = "ros_pose_stats simulate clamp.stl --unit mm --drops 1000"
LIBRARIES = "numpy, scipy.spatial, numba"
IMPORTS = (
    f"import os; os.environ.setdefault('OPENBLAS_NUM_THREADS', '1'); import {LIBRARIES}"
)
"""As commands import them."""

WALL = (
    "Whole processes in turn, from start to exit, files in the page cache and byte "
    "code compiled: wall time, and processor time of all threads. `first` comes right "
    "after `compile`, once; the others take turns."
)
COMPILING = (
    "`ros_pose_stats compile` with an empty cache, as `make setup` runs it: every "
    "kernel, on all cores. CPU: of all its processes. Once."
)


def measure(folder: Path) -> tuple[Section, ...]:
    """Time compiling, the first command, then warm ones beside bare imports.

    Machine code and parts go into an empty folder.
    """
    parts = write_demo_parts(folder / "parts")
    part = next(path for path in parts if path.stem == "clamp")
    cache = folder / "cache"
    cache.mkdir()
    estimate = ["estimate", str(part), "--unit", "mm"]
    simulate = ["simulate", str(part), "--unit", "mm", "--drops", "1000"]
    script = Path(sys.executable).with_name("ros_pose_stats")
    command = (
        [str(script)] if script.exists() else [sys.executable, "-m", "ros_pose_stats"]
    )
    compiling = _compile_section([*command, "compile"], cache)
    first = race(
        [Contender("first", lambda _: _process([*command, *estimate], cache))],
        Pace(1, 1.0),
    )
    calls = {
        COMMAND: [*command, *estimate],
        DROPPING: [*command, *simulate],
        f"import {LIBRARIES}": [sys.executable, "-c", IMPORTS],
        "python -c pass": [sys.executable, "-c", "pass"],
    }
    processor_times: dict[str, list[float]] = {name: [] for name in calls}

    def run(name: str) -> None:
        processor_times[name].append(_process(calls[name], cache))

    warm = race(
        [Contender(name, run, partial(str, name)) for name in calls],
        Pace(RUNS, 600.0),
    )
    return compiling, _start_section(first, warm, processor_times)


def _process(call: list[str], cache: Path) -> float:
    """Run to the end; processor time of the process and those that it starts."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    # Installed modules have their byte code, and so those of a checkout must keep it.
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(call, cwd=ROOT, env=environment, capture_output=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _compile_section(call: list[str], cache: Path) -> Section:
    """Wall and CPU time of compiling everything."""
    begin = time.perf_counter()
    spent = _process(call, cache)
    wall = time.perf_counter() - begin
    return Section(
        "compile",
        "Compiling the kernels",
        COMPILING,
        (
            Row(
                "ros_pose_stats compile",
                {"wall, s": wall, "CPU, s": spent},
                (
                    Target("wall, s", wall, COMPILE_WALL),
                    Target("CPU, s", spent, COMPILE_CPU),
                ),
            ),
        ),
    )


def _start_section(
    first: Timings, warm: Timings, processor_times: dict[str, list[float]]
) -> Section:
    whole = warm.median(COMMAND)
    dropping = warm.median(DROPPING)
    spent = {name: median(seconds) for name, seconds in processor_times.items()}
    targets = {
        COMMAND: (
            Target("wall, s", whole, LIMIT),
            Target("aim: CPU, s", spent[COMMAND], AIM),
        ),
        DROPPING: (Target("wall, s", dropping, DROPS),),
    }
    rows = [
        Row(
            name,
            {
                "wall, s": warm.median(name),
                "CPU, s": spent[name],
                "of the command": warm.ratio(name, COMMAND),
                "runs": len(seconds),
            },
            targets.get(name, ()),
        )
        for name, seconds in warm.seconds.items()
    ]
    ever = first.median("first")
    rows.append(
        Row(
            "first",
            {"wall, s": ever, "CPU, s": "", "of the command": ever / whole, "runs": 1},
            (Target("wall, s", ever, FIRST),),
        )
    )
    return Section("start", "Start of the command", WALL, tuple(rows))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="ros_pose_stats_") as name:
        run_benchmark(
            benchmark_parser("lab.benchmarks.start", __doc__ or ""),
            lambda _: measure(Path(name)),
        )
