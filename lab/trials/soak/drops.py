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

"""Drops of many bodies, all judged one by one."""

import numpy as np

from lab.bodies import shapes
from ros_pose_stats import Part, part_from_mesh, resting_poses, simulate

from ..frame import Outcome, Setting

DROPS = 1_000_000
BODIES = 200
RESTITUTIONS = (0.2, 0.5, 0.8)
MOST_UNSETTLED = 1e-5
"""Share of the drops that may be given up."""

ROUNDING = 1e-8
"""How far below its pose's height an energy may come out, in m g radius.

Corners touch within 1e-9, so a body at rest may lie that much too low at one of them.
"""


def body(number: int) -> Part:
    """A random polyhedron; every second one with its centre of mass anywhere well
    inside.
    """
    chance = np.random.default_rng([number, 5])
    surface = shapes.hull_mesh(
        chance.standard_normal((3 + int(chance.geometric(0.1)), 3))
    )
    inside = chance.dirichlet(np.ones(len(surface[0]))) @ surface[0]
    return part_from_mesh(*surface, center_of_mass=inside if number % 2 else None)


def many_drops(setting: Setting) -> Outcome:
    """A million drops of 200 bodies, each into a listed pose with the energy to stay
    there.
    """
    drops = setting.of(DROPS)
    bodies = setting.of(BODIES, 10)
    outcome = Outcome()
    unsettled = 0
    lowest = np.inf
    closest = np.inf
    for number in range(setting.seed, setting.seed + bodies):
        part = body(number)
        resting = resting_poses(part, 0.0, 0)
        height, barrier = (
            np.array([getattr(pose, name) for pose in resting.poses])
            / resting.body.radius
            for name in ("height", "barrier")
        )
        for restitution in RESTITUTIONS:
            share = max(1, drops // bodies // len(RESTITUTIONS))
            outcomes = []
            answer = simulate(
                part,
                share,
                restitution,
                number,
                cluster_tolerance=0.0,
                round_sides=0,
                on_drops=lambda chunk, chunks=outcomes: chunks.append(chunk.outcomes),
            )
            pose, energy, trapped, seconds = (
                np.concatenate(
                    [getattr(chunk_outcomes, name) for chunk_outcomes in outcomes]
                )
                for name in ("pose", "energy_left", "trapped", "seconds")
            )
            settled = pose >= 0
            lowest_gap = (energy - height[pose])[settled].min(initial=np.inf)
            barrier_gap = ((height + barrier)[pose] - energy)[settled & trapped].min(
                initial=np.inf
            )
            sound = {
                "as many drops as asked for": len(pose)
                == share
                == answer.unsettled
                + sum(chunk_outcomes.count for chunk_outcomes in answer.poses),
                "a stable pose": -1 <= pose.min() <= pose.max() < len(answer.poses),
                "numbers": np.isfinite(energy).all() and np.isfinite(seconds).all(),
                "the pose's energy": lowest_gap >= -ROUNDING,
                "too little to leave it": barrier_gap > 0.0,
            }
            outcome.broken += [
                f"not {name}: body {number} at {restitution}"
                for name, good in sound.items()
                if not good
            ]
            outcome.tried = outcome.tried + share
            unsettled = unsettled + answer.unsettled
            lowest = min(lowest, lowest_gap)
            closest = min(closest, barrier_gap)
    if unsettled > MOST_UNSETTLED * outcome.tried:
        outcome.broken.append(f"{unsettled} drops of {outcome.tried} did not settle")
    outcome.seen = (
        f"{unsettled} unsettled; at least {lowest:.1e} m g radius above the pose and "
        f"{closest:.1e} missing to leave it"
    )
    return outcome
