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

"""Numbers of the paper, which the tables compare with ours."""

from typing import Final

DROPS: Final = 100
"""Drops of each body at each restitution."""

ERRORS: Final = {
    "area": 0.112,
    "csae": 0.085,
    "adre": 0.078,
    "qse": 0.070,
    "pqse": 0.072,
    "nqse": 0.062,
    "eae": 0.068,
    "meae": 0.040,
    "combined": 0.036,
}
"""Average error of each estimator; Table I, the area estimator's from section 4.B."""

LARGEST: Final = {
    "csae": 0.435,
    "adre": 0.409,
    "qse": 0.458,
    "pqse": 0.425,
    "nqse": 0.449,
    "eae": 0.580,
    "meae": 0.327,
    "combined": 0.320,
}
"""Largest observed deviation from simulation; Table I."""

NOISE: Final = 0.0327
"""sigma(p, s), section 4.A (the square printed there is a slip)."""

SENSITIVITY: Final = 0.0563
"""sigma(p_0.2, p_0.8), section 5.A."""

OUTLIERS: Final = ((0.8, 0.320, 0.208), (0.2, 0.319, 0.225), (0.5, 0.295, 0.176))
"""Restitution and deviation after 100 and after 1 000 drops; section 4.F."""

MEAN_POSES: Final = 6665 / 1057
POSES: Final = (2, 21)
VERTICES: Final = (4, 23)
FACES: Final = (4, 42)
LARGEST_PROBABILITY: Final = 0.75
