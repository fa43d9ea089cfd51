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

"""Files that name no unit: in which one they are taken, and whether the answer says so.

    python -m lab.trials.units [--write]

Each is a flight of five stairs, 1 mm to 1 m long, whose lengths are multiples of a step
that people draw in; so its unit is known.
"""

from pathlib import Path

import numpy as np
import trimesh
from manifold3d import CrossSection, Manifold

from lab.bodies.degenerate import Random
from lab.bodies.shapes import Surface
from ros_pose_stats import load_part
from ros_pose_stats.base.text import length_in_words
from ros_pose_stats.core.mesh.units import METRES_PER_UNIT
from ros_pose_stats.core.records import Array

from .frame import Outcome, Setting, judged, program

FILES = 150  # of a full run, each trial
LENGTHS = (1e-3, 1.0)  # of the parts, metres; as many from 1 to 10 mm as above 100 mm
STAIRS = 5
SIXTEENTH = 0.0254 / 16.0
TENTH = 1e-4
SHARE = 0.99  # of files in millimetres that are to be read right
SHORT = 0.2


def stairs(random: Random, step: float) -> Surface:
    """A flight of stairs in metres, its lengths multiples of a step."""
    longest = np.exp(random.uniform(*np.log(LENGTHS))) / step
    treads, rises = _steps(random, longest / STAIRS, 2 * STAIRS).reshape(2, STAIRS)
    places = np.concatenate(([0.0], np.cumsum(treads)))
    heights = np.cumsum(rises)[::-1]
    top = [
        (places[k + end], height) for k, height in enumerate(heights) for end in (0, 1)
    ]
    outline = [(0.0, 0.0), (places[-1], 0.0), *top[::-1]]
    width = _steps(random, longest, 1)[0]
    mesh = Manifold.extrude(CrossSection([outline]), width).to_mesh64()
    return step * np.asarray(mesh.vert_properties), np.asarray(mesh.tri_verts)


def _steps(random: Random, most: float, count: int) -> Array:
    """Lengths up to a longest one, in whole steps."""
    return np.maximum(1.0, np.rint(random.uniform(0.2, 1.0, count) * most))


def read_files(setting: Setting, unit: str, step: float) -> Outcome:
    """Write files in a unit and read them without it."""
    count = setting.of(FILES)
    right = 0
    silent = 0
    for number in range(count):
        random = np.random.default_rng((setting.seed, number))
        file = setting.folder / "part.stl"
        length = write_stairs(file, random, METRES_PER_UNIT[unit], step)
        part = load_part(file)
        right += part.unit == METRES_PER_UNIT[unit]
        warning = str(next(iter(part.warnings), ""))
        is_warned = part.unit_guessed and warning.startswith("UNIT_GUESSED: ")
        # Single precision may round a length to another third digit.
        names_length = any(
            length_in_words(length * scale) in warning for scale in (1 - 1e-6, 1 + 1e-6)
        )
        silent += not (is_warned and names_length)
    return judged(
        count,
        f"{right} of {count} read in their unit, {silent} without their true length "
        "in the warning",
        read_in_their_unit=unit != "mm" or right >= SHARE * count,
        true_length_named=silent == 0,
    )


def write_stairs(file: Path, random: Random, unit: float, step: float) -> float:
    """Write a part in a unit of so many metres; its largest extent in metres."""
    vertices, triangles = stairs(random, step)
    trimesh.Trimesh(vertices / unit, triangles, process=False).export(file)
    return float(np.ptp(vertices, axis=0).max())


def millimetres(setting: Setting) -> Outcome:
    """Lengths at tenths of a millimetre, files in millimetres."""
    return read_files(setting, "mm", TENTH)


def inch_drawings_in_millimetres(setting: Setting) -> Outcome:
    """Lengths at sixteenths of an inch, files in millimetres."""
    return read_files(setting, "mm", SIXTEENTH)


def metres(setting: Setting) -> Outcome:
    """Lengths at tenths of a millimetre, files in metres."""
    return read_files(setting, "m", TENTH)


def inches(setting: Setting) -> Outcome:
    """Lengths at sixteenths of an inch, files in inches, which only a user can say."""
    return read_files(setting, "inch", SIXTEENTH)


TRIALS = (millimetres, inch_drawings_in_millimetres, metres, inches)

if __name__ == "__main__":
    raise SystemExit(program("units", TRIALS, SHORT))
