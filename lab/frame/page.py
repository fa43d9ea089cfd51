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

"""Pages of `docs/measured` from the results that programs have stored."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from .machine import describe_machine
from .results import Results, Row, Section, format_cell, load

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
NUMBERS = Path("measured") / "numbers"
"""Folder of the stored results below that of the documents."""


@dataclass(frozen=True)
class Page:
    """A page that is rendered from stored results.

    Attributes
    ----------
    name : str
        Of the file in `docs/measured`.
    introduction : str
        Title and first paragraphs.
    programs : tuple of str
        Names of the stored results, in the order of the page.
    """

    name: str
    introduction: str
    programs: tuple[str, ...]

    def write(self, docs: Path = DOCS) -> Path:
        """Render the page under a folder of documents from the numbers there."""
        files = [docs / NUMBERS / f"{name}.json" for name in self.programs]
        runs = [load(file) for file in files if file.exists()]
        page = docs / "measured" / self.name
        page.write_text(self.render(runs), encoding="utf-8")
        return page

    def render(self, runs: Sequence[Results]) -> str:
        """The text of the page, Markdown."""
        parts = [self.introduction, *_summarise_targets(runs)]
        for run in runs:
            machine = ", ".join(f"{key} {text}" for key, text in run.machine.items())
            parts.append(f"Measured on: {machine}.\n")
            for section in run.sections:
                parts.append(
                    f"## {section.title}\n\n{section.timed}\n\n{table(section)}\n"
                )
        return "\n".join(parts)


def _summarise_targets(runs: Sequence[Results]) -> list[str]:
    """How many targets are met, and those that are not, for the head of a page."""
    targets = [
        (row, target) for run in runs for row in run.rows for target in row.targets
    ]
    if not targets:
        return []
    missed = [f"- {row.name}: {target}" for row, target in targets if not target.is_met]
    count = f"{len(targets) - len(missed)} of {len(targets)} targets are met"
    if not missed:
        return [f"{count}.\n"]
    return [f"{count}; short of target:\n", *missed, ""]


def table(section: Section) -> str:
    """Markdown table: names, cells, and verdicts where there are targets."""
    columns = list(section.rows[0].cells)
    numbers = [
        column
        for column in columns
        if not all(isinstance(row.cells[column], str) for row in section.rows)
    ]
    has_targets = any(row.targets for row in section.rows)
    head = ["", *columns]
    rule = ["---", *("---:" if column in numbers else "---" for column in columns)]
    if has_targets:
        head.append("target")
        rule.append("---")
    lines = [head, rule]
    for row in section.rows:
        line = [row.name, *(format_cell(row.cells[column]) for column in columns)]
        if has_targets:
            line.append(_verdicts(row))
        lines.append(line)
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _verdicts(row: Row) -> str:
    """Each target with its value and limit; a miss in bold."""
    return "; ".join(
        f"{target}: PASS" if target.is_met else f"**{target}: short of target**"
        for target in row.targets
    )


def collect_results(
    sections: Iterable[Section], say: Callable[[str], object] = print
) -> Results:
    """Collect the sections as they are measured, and say each table as it comes."""
    machine = describe_machine()
    collected = []
    for section in sections:
        collected.append(section)
        say(f"\n{section.title}\n{table(section)}")
    return Results(machine, tuple(collected))
