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

"""Plates: what a real one does to parts, fitted from counts and kept in a file."""

from .counts import CountedPart, count_part, read_count_rows, read_counted_parts
from .fit import PartEvidence, PlateFit, fit_plate
from .profile import PlateProfile, profile_of, read_profiles, refuse_name, write_profile

__all__ = [
    "CountedPart",
    "PartEvidence",
    "PlateFit",
    "PlateProfile",
    "count_part",
    "fit_plate",
    "profile_of",
    "read_count_rows",
    "read_counted_parts",
    "read_profiles",
    "refuse_name",
    "write_profile",
]
