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

"""What tools of a ROS release read: catkin_pkg, and with it colcon and bloom."""

from datetime import date
from pathlib import Path

import pytest
from catkin_pkg.changelog import get_changelog_from_path
from catkin_pkg.package import parse_package
from packaging.version import Version

from ros_pose_stats import __version__

from .notices import files_without_notice

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = [ROOT, ROOT / "msg_defs"]


@pytest.mark.parametrize("folder", PACKAGES, ids=lambda folder: folder.name)
class TestPackage:
    def test_its_description_is_sound(self, folder):
        warnings = []
        package = parse_package(str(folder), warnings=warnings)
        package.validate(warnings=warnings)
        assert not warnings
        assert package.version == __version__
        assert package.authors and package.licenses == ["Apache-2.0"]
        assert package.licenses[0].file in (None, "LICENSE")

    @pytest.mark.filterwarnings("ignore:.*traverse:DeprecationWarning")
    def test_its_changelog_goes_by_versions(self, folder):
        changelog = get_changelog_from_path(str(folder / "CHANGELOG.rst"))
        entries = list(changelog.foreach_version())
        versions = [Version(version) for version, _, _ in entries]
        assert versions == sorted(versions, reverse=True)
        assert Version(__version__) in versions
        assert all(isinstance(day.date(), date) and notes for _, day, notes in entries)

    def test_its_licence_lies_beside_it(self, folder):
        licence = (folder / "LICENSE").read_text(encoding="utf-8")
        assert licence == (ROOT / "LICENSE").read_text(encoding="utf-8")


def test_every_source_file_has_the_notice():
    assert files_without_notice() == []
