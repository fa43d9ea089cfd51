"""Times of whole catalogues: `python -m lab.benchmarks.catalogues`.

One and two workers on the same generated parts, in processes of this machine and of a
dask.distributed cluster on it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import product
from pathlib import Path

import numpy as np

from ros_pose_stats.core.mesh.files import stl_bytes
from ros_pose_stats.tools.catalogue.making import (
    Maker,
    make_catalogue,
    on_cluster,
    on_processes,
)
from ros_pose_stats.tools.catalogue.request import (
    CatalogueRequest,
    PartFile,
    find_parts,
)
from study.random_parts import random_part

from .report import NUMBERS, machine, table, write_page
from .results import Results, Row, Section, Target, save

SEED = 61
PARTS = 1000
WARM = 60
ROUNDS = 3
SECONDS = 60.0
FASTER = 1.8
"""Aims: seconds for all parts on two cores, and two workers over one."""

MEASURED = (
    "Seconds from the command's first look at the folder to the written page, estimates only, of "
    "generated machined and turned parts as STL files. `one`, `two`: with so many workers, in "
    "turn, the shortest of some rounds. Those of the cluster have made a small catalogue before; "
    "processes start with each. Scheduler and client share the cores with the workers."
)


def write_parts(folder: Path, count: int) -> list[PartFile]:
    """Generated parts as STL files."""
    folder.mkdir()
    for number in range(count):
        vertices, triangles = random_part(SEED, number)
        (folder / f"part_{number:04d}.stl").write_bytes(
            stl_bytes(vertices, np.asarray(triangles))
        )
    return find_parts([folder])


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[str]:
    """Address of a scheduler with so many workers of one thread, as processes."""
    told = folder / f"scheduler_{workers}.json"
    with ExitStack() as running:

        def start(kind: str, *options: str) -> None:
            process = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    f"distributed.cli.dask_{kind}",
                    *options,
                    "--no-dashboard",
                ],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            running.callback(process.wait)
            running.callback(process.kill)

        start(
            "scheduler",
            "--host",
            "127.0.0.1",
            "--port",
            "0",
            "--scheduler-file",
            str(told),
        )
        while not (told.exists() and told.read_text().endswith("}")):
            time.sleep(0.05)
        address: str = json.loads(told.read_text())["address"]
        for _ in range(workers):
            start("worker", address, "--nworkers", "1", "--nthreads", "1", "--no-nanny")
        yield address


def seconds(folder: Path, parts: list[PartFile], maker: Maker) -> float:
    """Time that the catalogue of some parts takes in a new folder."""
    begin = time.perf_counter()
    made = make_catalogue(folder, parts, CatalogueRequest(unit="mm"), maker)
    took = time.perf_counter() - begin
    if made.tally.refused:
        raise RuntimeError(f"parts were refused: {made.tally.refused}")
    return took


def measure(folder: Path, count: int, rounds: int) -> Section:
    """Time processes and a cluster, one worker and two."""
    parts = write_parts(folder / "parts", count)
    times: dict[str, dict[int, list[float]]] = {
        "processes": {1: [], 2: []},
        "dask": {1: [], 2: []},
    }
    for number, workers in product(range(rounds), (1, 2)):
        mine = folder / f"{number}_{workers}"
        mine.mkdir()
        times["processes"][workers].append(
            seconds(mine / "here", parts, on_processes(workers))
        )
        with cluster(mine, workers) as address:
            seconds(mine / "warm", parts[:WARM], on_cluster(address))
            times["dask"][workers].append(
                seconds(mine / "there", parts, on_cluster(address))
            )
    rows = []
    for name, found in times.items():
        one = min(found[1])
        two = min(found[2])
        target = Target("two workers over one", one / two, FASTER, at_least=True)
        if name == "processes":
            target = Target(
                "seconds on two cores for each thousand", 1e3 * two / count, SECONDS
            )
        rows.append(
            Row(
                name,
                {"parts": count, "one, s": one, "two, s": two, "ratio": one / two},
                (target,),
            )
        )
    return Section("catalogues", "Catalogues", MEASURED, tuple(rows))


def main() -> None:
    """Measure, print, and with `--write` store the results and write the page."""
    parser = argparse.ArgumentParser(
        prog="lab.benchmarks.catalogues", description=__doc__.partition("\n")[0]
    )
    parser.add_argument(
        "--parts", type=int, default=PARTS, help="(default: %(default)s)"
    )
    parser.add_argument(
        "--write",
        action="store_true",
        help="store numbers/catalogues.json and render benchmarks.md in docs/measured",
    )
    parser.add_argument(
        "--rounds", type=int, default=ROUNDS, help="(default: %(default)s)"
    )
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        section = measure(Path(folder), options.parts, options.rounds)
    print(table(section))
    if options.write:
        save(Results(machine(), (section,)), NUMBERS / "catalogues.json")
        print(write_page())


if __name__ == "__main__":
    main()
