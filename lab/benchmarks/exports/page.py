"""The page `docs/measured/exports.md`."""

from __future__ import annotations

from pathlib import Path

from ..report import MEASURED, table
from ..results import Results

INTRODUCTION = """# One part, many exports

Written by `python -m lab.benchmarks.exports --write`; edits here are lost.

A CAD program divides a round surface into flat facets, more or fewer as its settings say. A part
that rolls loses energy at each facet, so that drops and estimates of the file as it is depend on
its division. Here round surfaces are taken as polygons of 192 sides a turn, whatever the file
has; the tables say what is left of the difference, and how near thrown parts are.
"""


def write_page(results: Results) -> Path:
    """Write the page and return its path."""
    short = [
        f"- {row.name}: {target}"
        for row in results.rows
        for target in row.targets
        if not target.met
    ]
    number = sum(len(row.targets) for row in results.rows)
    verdict = f"{number - len(short)} of {number} targets are met"
    found = [
        INTRODUCTION,
        "\n".join([f"{verdict}; short of target:\n", *short, ""])
        if short
        else f"{verdict}.\n",
    ]
    for section in results.sections:
        found.append(f"## {section.title}\n\n{section.timed}\n\n{table(section)}\n")
    where = ", ".join(f"{name} {value}" for name, value in results.machine.items())
    found.append(f"Measured on: {where}.\n")
    page = MEASURED / "exports.md"
    page.write_text("\n".join(found), encoding="utf-8")
    return page
