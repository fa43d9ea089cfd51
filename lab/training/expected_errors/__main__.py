"""Fits the expected errors of the estimators, and compares them with true ones on new bodies.

.venv/bin/python -m lab.training.expected_errors [--write]
"""

from __future__ import annotations

import argparse

from ros_pose_stats.core.estimators.fitted import ERROR_FILE

from ...benchmarks.report import NUMBERS, collect_results, write_page
from ...benchmarks.results import save
from ..split.samples import FIT_SEED, JUDGE_SEED, read_samples
from .fit import fit_errors, usual_errors, write_weights
from .judge import judged, sections
from .samples import error_samples


def main() -> None:
    """Fit, compare and print; with `--write` also write the weights and the tables."""
    parser = argparse.ArgumentParser(
        prog="lab.training.expected_errors", description=__doc__.partition("\n")[0]
    )
    parser.add_argument(
        "--write",
        action="store_true",
        help=f"write {ERROR_FILE.name}, and the tables to docs/measured/benchmarks.md",
    )
    write = parser.parse_args().write
    samples = read_samples()
    known = error_samples([one for one in samples if one.seed == FIT_SEED])
    fits = {name: fit_errors(some) for name, some in known.items()}
    if write:
        write_weights(fits, usual_errors())
    else:
        print(fits)
    new = judged([one for one in samples if one.seed == JUDGE_SEED], fits)
    results = collect_results(sections(new), print)
    if write:
        save(results, NUMBERS / "expected_errors.json")
        print(write_page())


if __name__ == "__main__":
    main()
