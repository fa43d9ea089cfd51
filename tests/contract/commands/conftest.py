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

"""Files that commands are asked about."""

import pytest

from lab.bodies import shapes
from tests.answers import write_stl


@pytest.fixture(scope="session")
def parts(tmp_path_factory):
    """A box of 20 x 30 x 40 mm in several states of repair, a bar, a cylinder, and what
    is no part.
    """
    folder = tmp_path_factory.mktemp("parts")
    vertices, triangles = shapes.box(20.0, 30.0, 40.0)
    write_stl(folder / "box.stl", (vertices, triangles))
    write_stl(folder / "bar.stl", shapes.box(40.0, 30.0, 29.8))
    write_stl(folder / "open.stl", (vertices, triangles[:-2]))
    write_stl(folder / "flat.stl", (vertices * (1.0, 1.0, 0.0), triangles))
    write_stl(folder / "cylinder.stl", shapes.cylinder(64, 9.0, 22.0))
    (folder / "empty.stl").touch()
    (folder / "notes.txt").write_text("not a mesh")
    return folder


@pytest.fixture(scope="session")
def box(parts):
    """The sound box and its unit."""
    return parts / "box.stl", "--unit", "mm"


@pytest.fixture(scope="session")
def bar(parts):
    """A bar whose long sides differ by less than a camera may see."""
    return parts / "bar.stl", "--unit", "mm"
