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

"""Mesh and STEP files of one's own, and the parts in them."""

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from ros_pose_stats import Part, load_part
from ros_pose_stats.base.errors import PoseStatsError
from ros_pose_stats.core.mesh.files import SUFFIXES


def files_in(folders: Sequence[Path]) -> list[Path]:
    """Every mesh and STEP file under some folders, and files given by name."""
    files = {
        file
        for folder in folders
        for file in (folder.rglob("*") if folder.is_dir() else [folder])
        if file.suffix.lower() in SUFFIXES
    }
    return sorted(files)


def loaded(files: Sequence[Path]) -> Iterator[tuple[str, Part]]:
    """Parts that can be loaded; others are told of on standard error."""
    for file in files:
        try:
            yield file.name, load_part(file, "auto")
        except PoseStatsError as error:
            print(f"left out: {error}", file=sys.stderr)
