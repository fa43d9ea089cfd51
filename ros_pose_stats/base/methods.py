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

"""The methods: what each is called, what decides in it, and what it needs.

Commands, their helps and the node take the names from here, and `estimators` finds the
functions. This module imports nothing heavy, so that helps are quick.
"""

from dataclasses import dataclass
from typing import Literal

HYBRID = "hybrid"
AUTO = "auto"
SIMULATION = "simulation"

OBSERVED = "observed"
"""Of a result that has learnt from what cameras counted; it cannot be asked for."""

DEFAULT_METHOD = AUTO  # default of the library, the commands and the node


@dataclass(frozen=True)
class Method:
    """One way to pose probabilities."""

    name: str  # as in requests and answers, lower case
    title: str  # for tables and figures
    about: str  # what decides in it, in one line
    # where it comes from in the paper, with the equation; empty for this project's own
    source: str = ""
    # module of `estimators` that has the function of that name; empty for what is no
    # estimator
    module: str = ""
    knows_scene: bool = False  # whether restitution and drop height change its answer
    # whether it simulates: some drops beside an estimate, or nothing but drops
    drops: Literal["none", "some", "all"] = "none"


METHODS = (
    Method(
        "area",
        "area",
        "surface area of the stable faces",
        "section 4.B, [24]",
        "published",
    ),
    Method("csae", "CSAE", "their centroid solid angle", "Eq. 5, [27]", "published"),
    Method(
        "adre",
        "ADRE",
        "centroid solid angle over height",
        "section 4.B, [28], [29]",
        "published",
    ),
    Method(
        "qse",
        "QSE",
        "centroid solid angle of every face, toppling until a face is stable",
        "section 4.B, [26]",
        "published",
    ),
    Method(
        "pqse",
        "PQSE",
        "the same, after moving probability to larger neighbours (our reading)",
        "section 4.B, [25] in our reading",
        "published",
    ),
    Method("nqse", "NQSE", "the fitted curve of Eq. 6 on `qse`", "Eq. 6", "published"),
    Method(
        "eae",
        "EAE",
        "a walk down the splitting graph of the energy, R",
        "Eqs. 7, 8",
        "published",
    ),
    Method(
        "meae",
        "MEAE",
        "the same with r, the distance to the surface",
        "Eq. 8 with r, Appendix C",
        "published",
    ),
    Method("combined", "combined", "0.75 `meae` + 0.25 `nqse`", "Eq. 9", "published"),
    Method(
        "split",
        "split",
        "the walk of `meae` with fitted weights; knows restitution, drop "
        "height and inertia",
        "section 4.D, weights fitted to simulations",
        "split",
        True,
    ),
    Method(
        HYBRID,
        "hybrid",
        "an estimate combined with drops until its expected error is down "
        "to the target",
        knows_scene=True,
        drops="some",
    ),
    Method(
        AUTO,
        "auto",
        "the most accurate estimator with drops beside it, at least 400, until its "
        "error is within the target with 90 % confidence, without a target within two "
        "points",
        knows_scene=True,
        drops="some",
    ),
    Method(
        SIMULATION,
        "simulation",
        "drops alone, counted",
        "section 3",
        knows_scene=True,
        drops="all",
    ),
)

AT_ONCE = (*(method.name for method in METHODS if method.module), AUTO)
"""Names of the estimators, and `auto`, whose answer is the best of them with drops
beside it."""

BESIDE_DROPS = tuple(method.name for method in METHODS if method.drops == "some")
"""Names of the methods that combine an estimate with drops."""
