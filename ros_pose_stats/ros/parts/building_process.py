"""Builds parts in a process of its own, which whoever started it may end at any moment.

It works as `batch.worker` does: nothing is left behind by a node that was killed.
"""

from __future__ import annotations

import os
import sys
from typing import Any, NamedTuple

from ...batch.worker import READY, answer, take_answers, work
from ...errors import PoseStatsError
from ...estimators import estimate
from ...kernels.compilation import all_kernels, prepare_kernels
from ...mesh.decimation import visible_triangles
from ...methods import AUTO
from ...records import DropScene, Part
from .part_requests import PartRequest, part_of

NICENESS = 10
"""Drops and answers come first."""


class BuildRequest(NamedTuple):
    """A mesh, or a part that is built already, and the scene of its first estimate."""

    request: PartRequest | Part
    scene: DropScene


class Built(NamedTuple):
    """A part with all that was prepared on the way to its first estimate and picture."""

    part: Part
    prepared: dict[Any, Any]


def build(asked: BuildRequest) -> Built | PoseStatsError | str:
    """Build a part as far as its first estimate and its first picture.

    Returns the refusal of a bad mesh, or what failed inside the program.
    """
    try:
        part = asked.request if isinstance(asked.request, Part) else part_of(asked.request)
        estimate(part, AUTO, cluster_tolerance=asked.scene.cluster_tolerance,
                 round_sides=asked.scene.round_sides)
        visible_triangles(part)  # for its markers
        return Built(part, part.all_prepared())
    except PoseStatsError as refusal:
        return refusal
    except Exception as error:  # belongs to whoever asked
        return f"{type(error).__name__}: {error}"


def main() -> None:
    """Give way to others, load the kernels, and work."""
    os.nice(NICENESS)
    answers = take_answers()
    all_kernels()
    prepare_kernels()
    answer(answers, READY)
    work(sys.stdin.buffer, answers)


if __name__ == "__main__":
    main()
