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

"""The study of fitted plates as a text and as a page."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lab.bodies.dice import SOURCE
from lab.frame.documents import markdown_table, plain, points, write_page

from .runs import COUNTED, FITTED, METHODS, PlateResults

PAGE = "plates.md"
TRUE = 0.7, 1.4
"""Told over true error that is near enough."""


def plates_text(results: PlateResults) -> str:
    """All plates as Markdown."""
    rows = [
        [
            plate.plate,
            *(points(plate.errors[method], 2) for method in METHODS),
            points(plate.told, 2),
            f"{plate.told / max(plate.errors['fit'], 1e-4):.2f}",
            f"{plate.default_weight:.2f}",
        ]
        for plate in results.plates
    ]
    simulated = results.plates[1:]
    rows.append(
        [
            "all but the dice",
            *(
                points(
                    _root_mean_square([plate.errors[method] for plate in simulated]), 2
                )
                for method in METHODS
            ),
            points(_root_mean_square([plate.told for plate in simulated]), 2),
            "",
            "",
        ]
    )
    count = sum(
        TRUE[0] <= plate.told / max(plate.errors["fit"], 1e-4) <= TRUE[1]
        for plate in simulated
    )
    worse = max(plate.errors["fit"] - plate.errors["default"] for plate in simulated)
    return "\n".join(
        [
            f"A plate is fitted to {FITTED} kinds of parts, and the others are "
            f"predicted by `split`; {results.splits} random choices. Errors in points: "
            "root mean square over groups of poses, the noise of the counts taken off. "
            f"Budden's fifteen dice ({SOURCE}) were rolled; the other plates are "
            "simulated with friction (`study/plates/friction.py`), twelve kinds of "
            f"parts, {COUNTED} counts of each of the "
            "five. `+ drops`: the same scenes, and in place of `split` the default "
            "answer, which drops the part as well until it is within two points of the "
            "model. All others: each part predicted by a fit to all other ones with "
            "all their counts, about what more counting can bring. Best scene: the "
            "scene of the grid with the least error, chosen by the very counts that "
            "judge it: about the best of one scene for all.",
            "",
            markdown_table(
                ("plate", *METHODS, "told", "told / true", "default's probability"),
                rows,
            ),
            "",
            f"Told over true is {TRUE[0]} to {TRUE[1]} on {count} of {len(simulated)} "
            f"simulated plates; the fit is at most {points(worse, 2)} points worse "
            "than the default on any.",
        ]
    )


def _root_mean_square(errors: Sequence[float]) -> float:
    return math.sqrt(float(np.mean(np.square(errors))))


def write_plates(results: PlateResults, folder: Path) -> list[Path]:
    """Write `measured/plates.md` and its numbers into a folder of documents."""
    head = (
        "# Fitted plates\n\nWritten by `python -m study plates -o docs`; edits here "
        "are lost. What is fitted, and how: [plates](../plates.md). Seed "
        f"{results.seed}.\n\n"
    )
    return write_page(
        folder, PAGE, f"{head}{plates_text(results)}\n", {}, {"plates": plain(results)}
    )
