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

"""The command line that benchmarks share, and the pages that they write."""

import argparse
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from ..frame.page import DOCS, NUMBERS, Page, collect_results
from ..frame.results import Section, save
from .speed import write_speed

BENCHMARKS = Page(
    "benchmarks.md",
    """# Benchmarks

Written by `python -m lab.benchmarks.core --write`, and so by `lab.benchmarks.meshes`,
`lab.benchmarks.start`, `lab.benchmarks.drops`, `lab.benchmarks.part_rates`,
`lab.benchmarks.rolls`,
`lab.training.expected_errors`, `lab.benchmarks.default_answer` and
`lab.benchmarks.node`, from
`docs/measured/numbers/*.json`; edits here are lost. The
machine was shared while these ran: contenders took turns within one run, so the ratios
are what counts, and times only give an idea. Kernels were compiled before, and times
are medians, unless said otherwise. [speed.md](speed.md) is the short page for users.
The load at the start is given with each run; on a busy machine the threads of the
linear algebra library wait for each other, which `OPENBLAS_NUM_THREADS=1` avoids.
""",
    (
        "core",
        "meshes",
        "start",
        "drops",
        "part_rates",
        "rolls",
        "expected_errors",
        "default_answer",
        "node",
    ),
)


def benchmark_parser(
    name: str, description: str, quick: str | None = None
) -> argparse.ArgumentParser:
    """A parser with `--write`, and `--quick` where its help is given."""
    parser = argparse.ArgumentParser(
        prog=f"python -m {name}", description=description.partition("\n")[0]
    )
    if quick is not None:
        parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument(
        "--write",
        action="store_true",
        help="store the numbers and render the page in docs/measured",
    )
    return parser


def run_benchmark(
    parser: argparse.ArgumentParser,
    measure: Callable[[argparse.Namespace], Iterable[Section]],
    page: Page = BENCHMARKS,
    middleware: Mapping[str, str] | None = None,
) -> None:
    """Measure, print, and with `--write` store the results and render their page.

    The results are stored by the last part of the program's name; the middleware, where
    it matters, is described with the machine.
    """
    options = parser.parse_args()
    if options.write and getattr(options, "quick", False):
        parser.error("--write stores full runs; leave --quick out")
    results = collect_results(measure(options))
    if options.write:
        name = parser.prog.rpartition(".")[2]
        results = replace(results, machine={**results.machine, **(middleware or {})})
        save(results, DOCS / NUMBERS / f"{name}.json")
        print(write_pages(page))


def write_pages(page: Page = BENCHMARKS, docs: Path = DOCS) -> Path:
    """Render a page and the one on speed, which stands on the numbers of several."""
    write_speed(docs)
    return page.write(docs)
