"""The page of the benchmarks from stored results, and the command line that they share."""

from __future__ import annotations

import argparse
import os
import platform
import time
from collections.abc import Callable, Iterable, Sequence
from datetime import date
from importlib.metadata import version
from pathlib import Path

from . import pictures
from .results import Results, Row, Section, format_cell, load, save
from .speed import write_speed

STORED = (
    "core",
    "start",
    "drops",
    "real_files",
    "catalogues",
    "feeding",
    "expected_errors",
    "auto",
    "checked",
    "node",
)

INTRODUCTION = """# Benchmarks

Written by `python -m lab.benchmarks.core --write`, and so by `lab.benchmarks.start`,
`lab.benchmarks.drops`, `lab.benchmarks.feeding`, `lab.training.expected_errors`,
`lab.benchmarks.auto`, `lab.benchmarks.checked` and `lab.benchmarks.node`, from
`docs/measured/numbers/*.json`; edits here are lost.
The machine was shared while these ran: contenders took turns within one run, so the ratios are
what counts, and times only give an idea. Kernels were compiled before, and times are medians,
unless said otherwise. [speed.md](speed.md) is the short page for users. The load at the start is
given with each run; on a busy machine the threads of the linear algebra library wait for each
other, which `OPENBLAS_NUM_THREADS=1` avoids.
"""


def collect_results(
    sections: Iterable[Section], say: Callable[[str], object]
) -> Results:
    """Collect the sections as they are measured, and say each table as it comes."""
    found = []
    where = machine()
    begin = time.monotonic()
    for section in sections:
        found.append(section)
        say(f"\n{section.title} ({time.monotonic() - begin:.0f} s)\n{table(section)}")
    return Results(where, tuple(found))


DOCS = Path(__file__).resolve().parents[2] / "docs"
MEASURED = DOCS / "measured"
NUMBERS = MEASURED / "numbers"


def write_page(docs: Path = DOCS) -> Path:
    """Render `measured/benchmarks.md`, `measured/speed.md` and their figures under `docs`.

    From `measured/numbers/*.json` there.
    """
    stored = [docs / "measured" / "numbers" / f"{name}.json" for name in STORED]
    found = [load(file) for file in stored if file.exists()]
    for results in found:
        for section in results.sections:
            pictures.draw(section, docs)
    page = docs / "measured" / "benchmarks.md"
    page.write_text(render_page(found), encoding="utf-8")
    write_speed(docs)
    return page


def render_page(runs: Sequence[Results]) -> str:
    """Render the whole page."""
    parts = [INTRODUCTION, _misses(runs)]
    for run in runs:
        where = ", ".join(f"{name} {value}" for name, value in run.machine.items())
        parts.append(f"Measured on: {where}.\n")
        for section in run.sections:
            parts.append(f"## {section.title}\n\n{section.timed}\n\n{table(section)}\n")
            if section.name in pictures.PICTURES:
                picture = pictures.PICTURES[section.name]
                parts.append(f"![{picture.says}](../{picture.file.as_posix()})\n")
    return "\n".join(parts)


def table(section: Section) -> str:
    """Markdown table: names, cells, and verdicts where there are targets."""
    columns = list(section.rows[0].cells)
    judged = any(row.targets for row in section.rows)
    lines = [["", *columns, *(["target"] * judged)]]
    lines.append(["---", *(["---:"] * len(columns)), *(["---"] * judged)])
    for row in section.rows:
        lines.append(
            [
                row.name,
                *(format_cell(row.cells[column]) for column in columns),
                *([_judged(row)] * judged),
            ]
        )
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _judged(row: Row) -> str:
    """Each target with its value and limit; a miss in bold."""
    return "; ".join(
        f"{target}: PASS" if target.met else f"**{target}: short of target**"
        for target in row.targets
    )


def _misses(runs: Sequence[Results]) -> str:
    """The targets that are missed, for the head of the page."""
    targets = [
        (row, target) for run in runs for row in run.rows for target in row.targets
    ]
    short = [f"- {row.name}: {target}" for row, target in targets if not target.met]
    met = f"{len(targets) - len(short)} of {len(targets)} targets are met"
    return (
        f"{met}.\n"
        if not short
        else "\n".join([f"{met}; short of target:\n", *short, ""])
    )


def command(
    name: str,
    about: str | None,
    quick: str,
    run: Callable[[bool], Results],
    arguments: Sequence[str] | None,
) -> None:
    """Measure, print, and with `--write` store the results and render the page.

    Parameters
    ----------
    name : str
        Of the benchmark: `core` is `python -m lab.benchmarks.core`, stored in `core.json`.
    about : str or None
        Description for `--help`.
    quick : str
        What `--quick` measures, for its help.
    run : callable
        Measures; with True, fewer things.
    arguments : sequence of str, optional
        Default: the process's own.
    """
    parser = argparse.ArgumentParser(prog=f"lab.benchmarks.{name}", description=about)
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument(
        "--write",
        action="store_true",
        help=f"store numbers/{name}.json and render benchmarks.md in docs/measured",
    )
    options = parser.parse_args(arguments)
    if options.quick and options.write:
        parser.error("--write stores full runs; leave --quick out")
    results = run(options.quick)
    if options.write:
        save(results, NUMBERS / f"{name}.json")
        print(write_page())


LIBRARIES = ("numpy", "scipy", "numba", "trimesh")


def machine() -> dict[str, str]:
    """Processor, cores, versions, the date, and what may slow a run down.

    Idle threads of the linear algebra library spin for a while; on a busy machine they take
    time from the calling thread, so their number and the load belong to a result.
    """
    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "python": platform.python_version(),
        **{library: version(library) for library in LIBRARIES},
        "BLAS threads": os.environ.get("OPENBLAS_NUM_THREADS", "default"),
        "load at the start": f"{os.getloadavg()[0]:.1f}",
        "date": date.today().isoformat(),
    }


def _processor() -> str:
    """Model name of the processor, where the system has it."""
    described = Path("/proc/cpuinfo")
    if described.exists():
        for line in described.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
