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

"""What `sensitivity` says that steps gain, beside many more drops of the same steps."""

from typing import NamedTuple

from ros_pose_stats import sensitivity

from .cases import SEED, Case
from .slopes import WORKERS, drop_classes


class Gain(NamedTuple):
    """A checked step of a part; changes as fractions."""

    family: str
    estimated: float
    low: float  # of the interval that `sensitivity` gives
    value: float
    high: float
    measured: float  # by the drops that judge it
    measured_error: float
    drops: int  # of the part before, and after, for the answer
    is_recommended: bool  # whether the answer says that it gains

    @property
    def loses(self) -> bool:
        """Whether the judging drops show a loss, beyond two standard errors."""
        return self.measured < -2.0 * self.measured_error


def measure_gains(case: Case, drops: int) -> list[Gain]:
    """Ask about a part, and drop each checked step so often, from other starts."""
    space = case.space
    scene = space.scene
    answer = sensitivity(
        space.part,
        case.model.goal.wanted_poses,
        seed=SEED,
        restitution=case.restitution,
        cluster_tolerance=scene.cluster_tolerance,
        round_sides=scene.round_sides,
        workers=WORKERS,
    )
    checked = answer.checked
    parts = [space.change_feature(0, 0.0)] + [
        space.change_feature(effect.number, effect.step) for effect, _ in checked
    ]
    before, *after = drop_classes(case, parts, drops, SEED + 1)
    gains = []
    for (effect, check), classes in zip(checked, after, strict=True):
        measured = case.model.goal.gain(before, classes)
        gains.append(
            Gain(
                case.family,
                effect.change,
                check.low,
                check.value,
                check.high,
                measured.value,
                measured.standard_error,
                answer.drops,
                effect.gains,
            )
        )
    return gains
