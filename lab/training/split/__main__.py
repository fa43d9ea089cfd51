"""Fits the split estimator.

python -m lab.training.split drops          counts the drops again (two hours; in parts)
python -m lab.training.split fit --write    fits, and writes the weights

`python -m lab.training.expected_errors` judges it on bodies that the fit has not seen.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from tempfile import gettempdir

from .counting import count_all, join_parts
from .fit import fit_all, write_weights
from .samples import read_samples, write_samples

PARTS = Path(gettempdir()) / "pose_stats_drops"


def main() -> None:
    """Drop or fit."""
    parser = argparse.ArgumentParser(
        prog="lab.training.split", description=__doc__.partition("\n")[0]
    )
    parser.add_argument("step", choices=("drops", "fit"))
    parser.add_argument("--write", action="store_true", help="write the weights")
    parser.add_argument(
        "--parts",
        type=Path,
        default=PARTS,
        help="for `drops`: folder of what is counted so far, which an interruption "
        "leaves (default: %(default)s)",
    )
    parser.add_argument(
        "--workers", type=int, default=2, help="threads (default: %(default)s)"
    )
    options = parser.parse_args()
    if options.step == "drops":
        count_all(options.parts, options.workers, _print_progress)
        write_samples(join_parts(options.parts))
    else:
        fits = fit_all(read_samples(), options.workers)
        print(fits)
        if options.write:
            write_weights(fits)


def _print_progress(counted: int, total: int) -> None:
    print(f"\r{counted} of {total} parts", end="", file=sys.stderr)


if __name__ == "__main__":
    main()
