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

"""Numbers of the prior, written by `python -m lab.training.fit_posterior`."""

FITTED_METHOD = "split"  # the estimator that they belong to
FITTED_AT = (0.2, 0.5, 0.8)  # restitutions of the rows below

FITTED = (
    (-0.3109, 0.2976, 0.0002339, 0.03047, 0.1783),
    (-0.0909, 0.2781, 2.522e-13, 0.03635, 0.2349),
    (-0.07352, 0.4204, 1.099e-05, 0.04609, 0.3199),
)
"""`PriorFit.center`, `spread`, `overrated`, `rare_below` and `unsure_share` at each."""
