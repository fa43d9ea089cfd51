"""Parts whose drops contradicted an estimate, beside what the present weights say of them.

.venv/bin/python -m training.conflicts FOLDER

The folder is `conflicts` in a node's log directory, or that of `estimate --keep-conflicts`.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ros_pose_stats import estimate
from ros_pose_stats.recording.conflicts import ConflictCase, read_conflicts
from ros_pose_stats.statistics.posterior.fitted import FITTED_METHOD
from ros_pose_stats.text import Column, columns, percent


class CaseScore(NamedTuple):
    """How far the present estimate is from the counts of a case, in fractions.

    Attributes
    ----------
    case : ConflictCase
    error : float
        Root mean square over the poses, the drops' noise taken off; 0 where that is larger.
    expected : float
        That the estimate tells.
    largest : float
        Largest difference of a pose.
    """

    case: ConflictCase
    error: float
    expected: float
    largest: float


def score_cases(folder: Path) -> Iterator[CaseScore]:
    """Estimate every part of a folder anew and set it beside its counts."""
    for case in read_conflicts(folder):
        scene, total = case.scene, case.counts.sum()
        found = estimate(case.part, FITTED_METHOD, restitution=scene.restitution,
                         drop_height=scene.drop_height,
                         cluster_tolerance=scene.cluster_tolerance, round_sides=scene.round_sides)
        said = np.array([pose.probability for pose in sorted(
            found.poses, key=lambda pose: pose.index)])
        if said.size != case.counts.size:
            continue  # its poses are others by now, so that it has to be dropped again
        share = case.counts / total
        square = np.mean(np.square(said - share) - share * (1.0 - share) / max(total - 1, 1))
        yield CaseScore(case, float(np.sqrt(max(square, 0.0))), found.expected_error,
                        float(np.abs(said - share).max()))


def main() -> None:
    """Print a row for each case, the worst first."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    scores = sorted(score_cases(parser.parse_args().folder), key=lambda one: -one.error)
    print("\n".join(columns(
        (Column("part", left=True), Column("poses"), Column("drops"), Column("restitution"),
         Column("error", "points"), Column("told", "points"), Column("largest", "points")),
        [(one.case.part.part_id, str(one.case.counts.size), str(one.case.counts.sum()),
          f"{one.case.scene.restitution:g}", percent(one.error), percent(one.expected),
          percent(one.largest)) for one in scores])))


if __name__ == "__main__":
    main()
