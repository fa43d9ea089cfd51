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

"""The page for users: the time that a part takes, by size, from stored results of
benchmarks.

`python -m lab.benchmarks.speed` writes docs/measured/speed.md anew without measuring
anything. Every benchmark that stores its results writes the page too.
"""

import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from lab.frame.documents import markdown_table, points
from lab.frame.page import DOCS, NUMBERS
from lab.frame.results import Results, Row, Section, format_cell, load
from study.chart.speed_accuracy import duration

MEASURED = ("core", "drops", "default_answer", "start", "node")
UNMERGED = ", tolerance 0"
"""End of the names of rows without a cluster tolerance; others have the default."""

INTRODUCTION = """# What a part costs

Written by `python -m lab.benchmarks.speed`, and by every benchmark that stores its
results, from `docs/measured/numbers/*.json`; edits here are lost. Times are medians on
one core unless said otherwise, with kernels that were compiled before. The machines,
named below, were shared while these ran, so times only give an idea.
[benchmarks.md](benchmarks.md) has the details, and every target that was met or missed.
"""

CHART = """## By size

![Time of a part on one core against the error of its probabilities, for four kinds of
part](../figures/speed_accuracy.png)

An estimate is the first answer, and drops lower its error. Time is from the mesh arrays
to the probabilities; the error is the root mean square over the poses in percentage
points, against the drop simulation's own limit. No poses of polyhedra are merged
(cluster tolerance 0); machined and turned parts are taken as users' files are. A real
plate adds some 5 points, whatever the method.
"""

DEMO_PARTS = """## The demo parts

Time from the mesh arrays to the answers of every estimator, beside that of trimesh,
which has the quasi-static estimator.
"""

DROP = """## A drop

Time of one drop on one thread, restitution 0.5, released 20 radii up.
"""

VERTICES = (100, 1000, 5000)

WANTED_ERROR = """## A wanted error

`auto` drops a part only as often as the wanted error takes. The table gives the mean
processor time a part, and the share of the cases that kept the error (90 % is
promised).
"""

CHOSEN = (
    ("estimate (`split`)", None, "split"),
    ("default answer (`auto`)", None, "default answer"),
    ("estimate and 100 drops (`hybrid`)", "hybrid", "n = 100"),
    ("1 000 drops", "drop simulation", "n = 1 000"),
    ("10 000 drops", "drop simulation", "n = 10 000"),
    ("`trimesh.poses`", None, "trimesh.poses"),
)
"""Points of the chart that the table shows: words, series and name."""


def write_speed(docs: Path = DOCS) -> Path:
    """Write `measured/speed.md` under `docs`, from `measured/numbers/*.json` there."""
    files = {name: docs / NUMBERS / f"{name}.json" for name in MEASURED}
    runs = {name: load(file) for name, file in files.items() if file.exists()}
    chart = json.loads((docs / NUMBERS / "chart.json").read_text(encoding="utf-8"))
    page = docs / "measured" / "speed.md"
    page.write_text(speed_page(runs, chart), encoding="utf-8")
    return page


def speed_page(runs: dict[str, Results], chart: dict[str, Any]) -> str:
    """The whole page, Markdown; what was not measured is left out.

    Parameters
    ----------
    runs : dict of str to Results
        What benchmarks stored, by the name of the file.
    chart : dict
        What `python -m study figures` stored.
    """
    sections = {
        section.name: section for run in runs.values() for section in run.sections
    }
    parts = [INTRODUCTION, CHART, f"{chart_table(chart)}\n"]
    for name, render in (
        ("demo", _demo_parts),
        ("drop_growth", _drop_growth),
        ("targets", _targets),
    ):
        if name in sections:
            parts.append(f"{render(sections[name])}\n")
    waits = markdown_table(("", "time"), _waits(sections))
    parts.append(f"## Waiting for an answer\n\n{waits}\n")
    parts.append("## Machines\n\n" + "\n".join(_machines(runs)) + "\n")
    return "\n".join(parts)


def chart_table(chart: dict[str, Any]) -> str:
    """Time and error of the chosen methods at each size of part."""
    sizes = chart["sizes"]
    rows = [
        (words, *(_point(size["points"], series, name) for size in sizes))
        for words, series, name in CHOSEN
    ]
    return markdown_table(("time, error", *(size["title"] for size in sizes)), rows)


def _point(measured: Iterable[dict[str, Any]], series: str | None, name: str) -> str:
    for point in measured:
        # Behind a comma the default answer has its number of drops.
        if (point["series"], point["name"].partition(",")[0]) == (series, name):
            return f"{duration(point['seconds'])}, {points(point['error'])}"
    return "-"


def _demo_parts(section: Section) -> str:
    rows = [
        (
            row.name.rpartition(", tolerance")[0],
            format_cell(row.cells["poses"]),
            _milliseconds(row.cells["all, ms"]),
            _milliseconds(row.cells["trimesh, ms"]),
        )
        for row in section.rows
        if not row.name.endswith(UNMERGED)
    ]
    head = ("part", "poses", "all estimators", "trimesh")
    return f"{DEMO_PARTS}\n{markdown_table(head, rows)}"


def _drop_growth(section: Section) -> str:
    families: dict[str, list[Row]] = {}
    for row in section.rows:
        families.setdefault(row.name.rpartition(", ")[0], []).append(row)
    rows = [
        (family, *(_of_drop(sizes_of, vertices) for vertices in VERTICES))
        for family, sizes_of in families.items()
    ]
    head = (
        "time (vertices)",
        *(f"about {format_cell(size)} vertices" for size in VERTICES),
    )
    return f"{DROP}\n{markdown_table(head, rows)}"


def _of_drop(rows: Sequence[Row], vertices: int) -> str:
    """Time for the body whose number of vertices is nearest, on a logarithmic scale."""
    nearest = min(
        rows, key=lambda row: abs(math.log(float(row.cells["vertices"]) / vertices))
    )
    return (
        f"{duration(1e-6 * float(nearest.cells['µs a drop']))} "
        f"({format_cell(nearest.cells['vertices'])})"
    )


def _targets(section: Section) -> str:
    rows = [
        (
            row.name.replace("1 points", "1 point"),
            _milliseconds(row.cells["ms"]),
            f"{format_cell(row.cells['kept'])} %",
        )
        for row in section.rows
    ]
    return f"{WANTED_ERROR}\n{markdown_table(('error', 'time', 'kept'), rows)}"


def _waits(sections: dict[str, Section]) -> Iterable[tuple[str, str]]:
    """Times that a user waits: words and median."""
    for name, row_name, cell, unit, words in WAITS:
        for row in sections[name].rows if name in sections else ():
            if row.name == row_name:
                yield words, duration(unit * float(row.cells[cell]))


ESTIMATE = "ros_pose_stats estimate clamp.stl --unit mm"
SIMULATE = "ros_pose_stats simulate clamp.stl --unit mm --drops 1000"
WAITS = (
    (
        "compile",
        "ros_pose_stats compile",
        "wall, s",
        1.0,
        "compiling all kernels, once a machine",
    ),
    ("start", ESTIMATE, "wall, s", 1.0, f"`{ESTIMATE}`, from start to exit"),
    ("start", SIMULATE, "wall, s", 1.0, f"`{SIMULATE}`, likewise"),
    ("node_start", "node", "ready", 1.0, "the node, from its start to `ready`"),
    *(
        (
            "mesh_to_estimate",
            f"{body}, PartMesh",
            "median, ms",
            1e-3,
            f"from publishing a mesh to its latched estimate, {body}",
        )
        for body in (
            "ring, 1000 triangles",
            "ring, 9984 triangles",
            "ring, 100000 triangles",
        )
    ),
    *(
        (
            "services",
            f"estimate, known part, {load}",
            "median, ms",
            1e-3,
            f"`~/estimate` of a known part, {words}",
        )
        for load, words in (
            ("idle", "nothing else running"),
            ("full load", "while a simulation takes all cores"),
        )
    ),
)
"""Section, row, column, seconds a unit, and what a user waits for."""


def _machines(runs: dict[str, Results]) -> Iterable[str]:
    yield "- `numbers/chart.json` (by size): not recorded"
    for name, run in runs.items():
        machine = run.machine
        yield (
            f"- `numbers/{name}.json`: {machine['processor']}, {machine['cores']} "
            f"cores, Python {machine['python']}, {machine['date']}"
        )


def _milliseconds(value: float | int | str) -> str:
    return duration(1e-3 * float(value))


if __name__ == "__main__":
    print(write_speed())
