"""The page for users: the time that a part takes, by size, from stored results of benchmarks.

`python -m lab.benchmarks.speed` writes docs/measured/speed.md anew without measuring anything.
Every benchmark that stores its results writes the page too.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from study.chart.speed_accuracy import duration
from study.output import markdown_table, points

from .results import Results, Row, Section, format_cell, load

DOCS = Path(__file__).resolve().parents[2] / "docs"
MEASURED = ("core", "drops", "auto", "start", "node")
TOLERANCE = ", tolerance 0.005"
"""End of the names of rows at the default cluster tolerance."""

INTRODUCTION = """# What a part costs

Written by `python -m lab.benchmarks.speed`, and by every benchmark that stores its results, from
`docs/measured/numbers/*.json`; edits here are lost. Times are medians on one core unless said
otherwise, with kernels that were compiled before. The machines, named below, were shared while
these ran, so times only give an idea. [benchmarks.md](benchmarks.md) has the details, and every
target that was met or missed.
"""

CHART = """## By size

![Time of a part on one core against the error of its probabilities, for four kinds of
part](../figures/speed_accuracy.png)

An estimate is the first answer, and drops lower its error. Time is from the mesh arrays to the
probabilities; the error is the root mean square over the poses in percentage points, against the
drop simulation's own limit. No poses of polyhedra are merged (cluster tolerance 0); machined and
turned parts are taken as users' files are. A real plate adds some 5 points, whatever the method.
"""

DEMO_PARTS = """## The demo parts

Time from the mesh arrays to the answers of every estimator, beside that of trimesh, which has the
quasi-static estimator.
"""

DROP = """## A drop

Time of one drop on one thread, restitution 0.5, released 20 radii up.
"""

VERTICES = (100, 1000, 5000)

WANTED_ERROR = """## A wanted error

`auto` drops a part only as often as the wanted error takes. The table gives the mean processor
time a part, and the share of the cases that kept the error (90 % is promised).
"""

CHOSEN = (
    ("estimate (`split`)", None, "split"),
    ("estimate and 100 drops (`hybrid`)", "hybrid", "n = 100"),
    ("1 000 drops", "drop simulation", "n = 1 000"),
    ("10 000 drops", "drop simulation", "n = 10 000"),
    ("`trimesh.poses`", None, "trimesh.poses"),
    ("100 drops in MuJoCo", "MuJoCo", "n = 100"),
)
"""Points of the chart that the table shows: words, series and name."""


class Stored(NamedTuple):
    """The stored results that the page is made of.

    Attributes
    ----------
    runs : dict of str to Results
        What `benchmarks` stored, by the name of the file.
    chart : dict, optional
        What `python -m study figures` stored.
    """

    runs: dict[str, Results]
    chart: dict[str, Any] | None

    def find(self, name: str) -> Section | None:
        """Section of that name, whichever run has it."""
        sections = (section for run in self.runs.values() for section in run.sections)
        return next((section for section in sections if section.name == name), None)


def read_stored(docs: Path) -> Stored:
    """Read the results under a folder of documents; missing ones are left out."""
    folder = docs / "measured" / "numbers"
    files = {name: folder / f"{name}.json" for name in MEASURED}
    chart = folder / "chart.json"
    return Stored(
        {name: load(file) for name, file in files.items() if file.exists()},
        json.loads(chart.read_text(encoding="utf-8")) if chart.exists() else None,
    )


def write_speed(docs: Path) -> Path:
    """Write `measured/speed.md` under `docs`, from `measured/numbers/*.json` there."""
    page = docs / "measured" / "speed.md"
    page.write_text(speed_page(read_stored(docs)), encoding="utf-8")
    return page


def speed_page(stored: Stored) -> str:
    """The whole page, Markdown; what was not measured is left out."""
    parts = [INTRODUCTION]
    if stored.chart is not None:
        parts += [CHART, f"{chart_table(stored.chart)}\n"]
    for section, write in (
        (stored.find("demo"), _demo_parts),
        (stored.find("drop_growth"), _drop_growth),
        (stored.find("auto"), _targets),
    ):
        if section is not None:
            parts.append(f"{write(section)}\n")
    waits = list(_waits(stored))
    if waits:
        parts.append(
            "## Waiting for an answer\n\n" + markdown_table(("", "time"), waits) + "\n"
        )
    parts.append("## Machines\n\n" + "\n".join(_machines(stored)) + "\n")
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
    for one in measured:
        if (one["series"], one["name"]) == (series, name):
            return f"{duration(one['seconds'])}, {points(one['error'])}"
    return "-"


def _demo_parts(section: Section) -> str:
    rows = [
        (
            row.name.removesuffix(TOLERANCE),
            format_cell(row.cells["poses"]),
            _milliseconds(row.cells["all, ms"]),
            _milliseconds(row.cells["trimesh, ms"]),
        )
        for row in section.rows
        if row.name.endswith(TOLERANCE)
    ]
    head = ("part", "poses", "all estimators", "trimesh")
    return f"{DEMO_PARTS}\n{markdown_table(head, rows)}"


def _drop_growth(section: Section) -> str:
    families: dict[str, list[Row]] = {}
    for row in section.rows:
        families.setdefault(row.name.rpartition(", ")[0], []).append(row)
    rows = [
        (family, *(_of_drop(found, vertices) for vertices in VERTICES))
        for family, found in families.items()
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
            row.name.removeprefix("auto, ").replace("1 points", "1 point"),
            _milliseconds(row.cells["auto, ms"]),
            f"{format_cell(row.cells['kept'])} %",
        )
        for row in section.rows
        if row.name.endswith("points")
    ]
    return f"{WANTED_ERROR}\n{markdown_table(('error', 'time', 'kept'), rows)}"


def _waits(stored: Stored) -> Iterable[tuple[str, str]]:
    """Times that a user waits: words and median."""
    for name, row, cell, unit, words in WAITS:
        section = stored.find(name)
        for one in section.rows if section is not None else ():
            if one.name == row:
                yield words, duration(unit * float(one.cells[cell]))


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


def _machines(stored: Stored) -> Iterable[str]:
    if stored.chart is not None:
        yield "- `numbers/chart.json` (by size): not recorded"
    for name, run in stored.runs.items():
        told = {
            "processor": "{}",
            "cores": "{} cores",
            "python": "Python {}",
            "date": "{}",
        }
        where = ", ".join(
            words.format(run.machine[key])
            for key, words in told.items()
            if key in run.machine
        )
        yield f"- `numbers/{name}.json`: {where}"


def _milliseconds(value: float | int | str) -> str:
    return duration(1e-3 * float(value))


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the page from what is stored."""
    argparse.ArgumentParser(
        prog="lab.benchmarks.speed", description=__doc__
    ).parse_args(arguments)
    print(write_speed(DOCS))


if __name__ == "__main__":
    main()
