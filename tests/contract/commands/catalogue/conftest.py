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

"""Catalogues, made once a file of tests."""

import shutil

import pytest

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from tests.answers import write_stl
from tests.running import answer_json, call

from .parts import ASKED, REFUSED, ROCKS, set_parts


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """Where parts lie, what is none, and what is not to be looked at; `set_parts` adds
    two.
    """
    home = tmp_path_factory.mktemp("catalogue")
    parts = home / "parts"
    (parts / "below" / ".cache").mkdir(parents=True)
    for name in ("box.stl", "b\udcf6x, 1.stl"):
        write_stl(parts / name, shapes.box(1.0, 2.0, 3.0))
    for seed in range(ROCKS):
        write_stl(parts / "below" / f"rock_{seed}.STL", random_polyhedron(9, seed))
    for name, content in REFUSED.items():
        (parts / name).write_bytes(content)
    (parts / "notes.txt").write_text("no part")
    for hidden in (".hidden.stl", "below/.cache/box.stl"):
        write_stl(parts / hidden, shapes.box(1.0, 2.0, 3.0))
    (parts / "below" / "up").symlink_to("..")
    (home / "\ufeff =1+1.stl").write_text("no part")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(home)
        yield home


@pytest.fixture(scope="module")
def catalogue(home):
    """The late parts in one go: what the command prints with `--json`, and its folder.

    A file beside the parts may have the name of a module that the work needs.
    """
    set_parts(home / "parts", late=True)
    (home / "queue.py").write_text("import pathlib; pathlib.Path('ran').touch(); 1 / 0")
    values = answer_json(*ASKED, "-o", "out", "--parquet")
    (home / "queue.py").unlink()
    return values, home / "out"


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    """A folder with two boxes, and one with their catalogue."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "parts").mkdir()
    for name, length in (("flat", 10.0), ("high", 40.0)):
        write_stl(folder / "parts" / f"{name}.stl", shapes.box(length, 20.0, 30.0))
    made = folder / "out"
    request = "catalogue", folder / "parts", "--unit", "mm", "--workers", 1
    assert call(*request, "-o", made).returncode == 0
    return request, made


@pytest.fixture
def made(boxes, tmp_path):
    """A copy of that catalogue, and how to ask for it again."""
    request, made = boxes
    shutil.copytree(made, tmp_path / "out")
    return tmp_path / "out", (*request, "-o", tmp_path / "out")
