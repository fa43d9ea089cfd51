"""Fits and judges the split estimator.

.venv/bin/python -m lab.training.split drops          counts the drops again (two hours; in parts)
.venv/bin/python -m lab.training.split fit --write    fits, and writes the weights
.venv/bin/python -m lab.training.split judge --write  judges, and writes docs/measured/split.md
.venv/bin/python -m lab.training.split judge --refits --write  also without folds and families
.venv/bin/python -m lab.training.split parts --write  judges the demo parts alone, likewise
.venv/bin/python -m lab.training.split parts FILE ... judges parts of one's own
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from tempfile import gettempdir

from ros_pose_stats.core.estimators.fitted import SPLIT_FITS

from ...benchmarks.report import machine
from .counting import count_all, join_parts
from .fit import write_weights
from .judge import Score, fit_all, judge, judge_refits
from .page import page, part_table, plain, plain_parts
from .real_parts import demo_parts, judge_parts, mesh_files
from .samples import read_samples, write_samples

MEASURED = Path(__file__).resolve().parents[3] / "docs" / "measured"
PARTS = Path(gettempdir()) / "pose_stats_drops"


def main() -> None:
    """Drop, fit or judge."""
    parser = argparse.ArgumentParser(
        prog="lab.training.split", description=__doc__.partition("\n")[0]
    )
    parser.add_argument("what", choices=("drops", "fit", "judge", "parts"))
    parser.add_argument("files", nargs="*", type=Path, help="for `parts`: meshes")
    parser.add_argument(
        "--write", action="store_true", help="write what is found to its place"
    )
    parser.add_argument(
        "--refits",
        action="store_true",
        help="for `judge`: also fit without folds of bodies and without families",
    )
    parser.add_argument(
        "--parts",
        type=Path,
        default=PARTS,
        help="for `drops`: folder of what is "
        "counted so far, which an interruption leaves (default: %(default)s)",
    )
    parser.add_argument(
        "--workers", type=int, default=2, help="threads (default: %(default)s)"
    )
    options = parser.parse_args()
    if options.what == "drops":
        count_all(
            options.parts,
            options.workers,
            lambda done, all_: print(
                f"\r{done} of {all_} parts", end="", file=sys.stderr
            ),
        )
        write_samples(join_parts(options.parts))
    elif options.what == "fit":
        fits = fit_all(read_samples(), options.workers)
        print(fits)
        if options.write:
            write_weights(fits)
    elif options.files:
        if options.write:
            parser.error(
                "--write is for the demo parts; leave the files out, or print only"
            )
        print(part_table(plain_parts(judge_parts(mesh_files(options.files), say))))
    else:
        stored = MEASURED / "numbers" / "split.json"
        found = (
            json.loads(stored.read_text(encoding="utf-8"))
            if options.what == "parts"
            else plain(_judged(options.refits, options.workers), machine())
        )
        found["parts"] = plain_parts(judge_parts(demo_parts(), say))
        print(page(found))
        if options.write:
            (MEASURED / "split.md").write_text(page(found), encoding="utf-8")
            stored.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def _judged(refits: bool, workers: int) -> dict[str, list[Score]]:
    samples = read_samples()
    scores = judge(samples, SPLIT_FITS)
    return {**scores, **judge_refits(samples, workers, say)} if refits else scores


def say(step: str) -> None:
    """Tell how far it is."""
    print(step, file=sys.stderr)


if __name__ == "__main__":
    main()
