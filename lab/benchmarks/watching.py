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

"""How soon `report --watch` shows a save, and what it holds after many.

    python -m lab.benchmarks.watching [--quick]

Real processes, and Chromium where there is one.
"""

import argparse
import signal
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import median

import trimesh

from lab.bodies.samples import clamp_hull
from lab.bodies.shapes import Surface, hull_mesh, sphere_points
from lab.bodies.variants import subdivided
from lab.frame.page import collect_results
from lab.frame.results import Row, Section, Target
from ros_pose_stats.core.shapes.demo_parts import DEMO_PARTS
from ros_pose_stats.tools.watching.followed_file import FollowedFile
from tests.contract.pages.browser import Browser, browser_file
from tests.contract.pages.watching import WatchingCommand

SAVES = 20
QUICK_SAVES = 5
MANY_SAVES = 1000
QUICK_MANY_SAVES = 40
STRETCH = 0.01  # by which a part grows along one axis, from save to save
STRETCHES = 30  # different parts; then it begins anew

LIMIT_SECONDS = 0.5
LIMIT_MEMORY = 20.0
LIMIT_END = 2.0
"""Seconds to the page, MB that many saves may add to the process, and seconds to its
end."""

SHOWN = """new Promise(done => {{
  const look = () => document.getElementById("version").dataset.version === "{}"
    ? done(true) : setTimeout(look, 2);
  look();
}})"""


def bodies() -> dict[str, Surface]:
    """By name parts of some 2000 triangles: few large faces, a thousand small ones."""
    clamp = DEMO_PARTS["clamp"]()
    while len(clamp[1]) < 1000:
        clamp = subdivided(clamp)
    return {"clamp, cut finer": clamp, "pebble": hull_mesh(sphere_points(1002, 1))}


def save(file: Path, surface: Surface, number: int) -> None:
    """Save a part as its version of a number."""
    vertices, triangles = surface
    growth = 1.0 + STRETCH * (number % STRETCHES)
    mesh = trimesh.Trimesh(vertices * (1.0, 1.0, growth), triangles, process=False)
    mesh.export(file.with_suffix(".new"), file_type="stl")
    file.with_suffix(".new").replace(file)


def time_saves(
    file: Path, surface: Surface, saves: int, wait: Callable[[int], object]
) -> list[float]:
    """Seconds from each save to its version; `wait`: until a version is shown."""
    seconds = []
    for number in range(1, saves + 1):
        save(file, surface, number)
        begin = time.perf_counter()
        wait(number + 1)
        seconds.append(time.perf_counter() - begin)
    return seconds


def time_page(folder: Path, name: str, surface: Surface, saves: int) -> Row:
    """From a save to the changed page in the browser."""
    file = folder / "part.stl"
    save(file, surface, 0)
    command = WatchingCommand(file)
    browser = Browser(folder / f"profile of {name}")

    def wait(number: int) -> None:
        browser.evaluate(SHOWN.format(number))

    try:
        browser.open(command.address)
        wait(1)
        before = heap_megabytes(browser)
        seconds = time_saves(file, surface, saves, wait)
        added = heap_megabytes(browser) - before
    finally:
        browser.close()
        command.end()
    cells = {
        "triangles": len(surface[1]),
        "median, s": median(seconds),
        "longest, s": max(seconds),
        "heap added, MB": added,
        "saves": saves,
    }
    return Row(name, cells, (Target("median, s", median(seconds), LIMIT_SECONDS),))


def heap_megabytes(browser: Browser) -> float:
    """What the script of the page holds."""
    browser.ask("HeapProfiler.collectGarbage")
    return browser.ask("Runtime.getHeapUsage")["usedSize"] / 1e6


def page_section(folder: Path, saves: int) -> Section:
    """Parts of two kinds."""
    return Section(
        "page",
        "From a save to the page",
        "From the rename of a saved STL file to the page in Chromium that shows its "
        "version with pictures, both processes on this machine.",
        tuple(
            time_page(folder, name, surface, saves)
            for name, surface in bodies().items()
        ),
    )


def reading_section(folder: Path, saves: int) -> Section:
    """From a save to the moment at which the file is read."""
    file = FollowedFile(folder / "read.stl")
    surface = clamp_hull()
    save(file.path, surface, 0)
    file.take()
    with ThreadPoolExecutor(1) as pool:
        seconds = []
        for number in range(1, saves + 1):
            reading = pool.submit(file.wait_for_save, lambda: False)
            save(file.path, surface, number)
            begin = time.perf_counter()
            reading.result()
            seconds.append(time.perf_counter() - begin)
    looks = 1000
    begin = time.perf_counter()
    for _ in range(looks):
        file.is_saved_anew()
    look = (time.perf_counter() - begin) / looks
    cells = {
        "median, s": median(seconds),
        "longest, s": max(seconds),
        "a look, µs": 1e6 * look,
        "saves": saves,
    }
    return Section(
        "reading",
        "From a save to its reading",
        "From the rename of a file to the end of the wait for it to rest, and what one "
        "look at the file takes.",
        (Row("hull of the clamp", cells),),
    )


def memory_section(folder: Path, saves: int) -> Section:
    """Memory of the process after many saves, and how soon it ends."""
    file = folder / "many.stl"
    surface = clamp_hull()
    save(file, surface, 0)
    command = WatchingCommand(file)

    def wait(number: int) -> None:
        news = command.news()
        while news["version"] < number:
            news = command.news(news["number"], news["version"])

    wait(1)
    tenth = saves // 10
    time_saves(file, surface, tenth, wait)
    before = resident_megabytes(command.process.pid)
    for number in range(tenth + 1, saves + 1):
        save(file, surface, number)
        wait(number + 1)
    added = resident_megabytes(command.process.pid) - before
    begin = time.perf_counter()
    command.end(signal.SIGTERM)
    end = time.perf_counter() - begin
    cells = {"saves": saves, "before, MB": before, "added, MB": added, "end, s": end}
    limits = (
        Target("added, MB", added, LIMIT_MEMORY),
        Target("end, s", end, LIMIT_END),
    )
    return Section(
        "memory",
        "Memory over many saves",
        "Resident memory of the process: after a tenth of the saves, and what the "
        "others add; each is shown before the next. Then how long it takes to end "
        "after SIGTERM.",
        (Row("hull of the clamp", cells, limits),),
    )


def resident_megabytes(process: int) -> float:
    """Memory of a process that is in use."""
    status = Path(f"/proc/{process}/status").read_text()
    (line,) = (line for line in status.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1e3


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="lab.benchmarks.watching")
    parser.add_argument("--quick", action="store_true", help="few saves")
    is_quick = parser.parse_args().quick
    with tempfile.TemporaryDirectory(prefix="ros_pose_stats_") as name:
        folder = Path(name)
        sections = [reading_section(folder, QUICK_SAVES if is_quick else SAVES)]
        if browser_file() is not None:
            sections.append(page_section(folder, QUICK_SAVES if is_quick else SAVES))
        sections.append(
            memory_section(folder, QUICK_MANY_SAVES if is_quick else MANY_SAVES)
        )
        collect_results(sections)


if __name__ == "__main__":
    main()
