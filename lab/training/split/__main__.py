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

"""Fits the split estimator.

python -m lab.training.split drops          counts the drops again, for two hours
python -m lab.training.split fit --write    fits, and writes the weights
python -m lab.training.split hold --families NAME ...
    fits without some families, and sets the errors beside those of the weights there
    are

`python -m lab.training.expected_errors` judges it on bodies that the fit has not seen.
"""

import argparse
import sys
from pathlib import Path
from tempfile import gettempdir

from ros_pose_stats.core.estimators.fitted import SPLIT_FITS

from .counting import BODIES, count_all, join_series
from .fit import fit_all, write_weights
from .judge import errors_by_family, errors_table
from .samples import read_samples, write_samples

WORKERS = 2
COUNTED = Path(gettempdir()) / "pose_stats_drops"
"""Threads, and what is counted so far, which an interruption leaves."""


def main() -> None:
    """Drop, fit, or fit without some families."""
    parser = argparse.ArgumentParser(
        prog="lab.training.split", description=__doc__.partition("\n")[0]
    )
    parser.add_argument("step", choices=("drops", "fit", "hold"))
    parser.add_argument("--write", action="store_true", help="write the weights")
    parser.add_argument(
        "--families",
        nargs="+",
        choices=BODIES,
        default=list(BODIES),
        help="for `drops`: those to count, where the others stay as the file has them; "
        "for `hold`: those that the fit does not see (default: all)",
    )
    options = parser.parse_args()
    if options.step == "hold" and set(options.families) == set(BODIES):
        parser.error("name the families that the fit is not to see")
    if options.step == "drops":
        families = options.families
        count_all(COUNTED, WORKERS, _print_progress, families)
        kept = read_samples() if set(families) != set(BODIES) else []
        write_samples(join_series(COUNTED, families, kept))
    elif options.step == "hold":
        samples = read_samples()
        fits = fit_all(
            [row for row in samples if row.family not in options.families],
            WORKERS,
        )
        errors = errors_by_family(samples, (SPLIT_FITS, fits))
        print(errors_table(errors, ("shipped", "held out")))
    else:
        fits = fit_all(read_samples(), WORKERS)
        print(fits)
        if options.write:
            write_weights(fits)


def _print_progress(counted: int, total: int) -> None:
    print(f"\r{counted} of {total} bodies", end="", file=sys.stderr)


if __name__ == "__main__":
    main()
