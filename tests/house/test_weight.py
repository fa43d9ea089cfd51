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

"""Folders are not crowded, tests come through the door, and the scales weigh what they
say.
"""

import ast
import json

import pytest

from tests.house import weight
from tests.house.weight import PACKAGE, ROOT, inner_imports, python_files

MOST_SIBLINGS = 20
"""Files and folders in a folder."""

INNER_IMPORTS = {"tests/contract": 0, "tests/golden": 3}
"""Imports of the product's inside by tests: users have none, golden makes its parts by
three.
"""


@pytest.mark.parametrize("tree", [PACKAGE, "tests"])
def test_no_folder_is_crowded(tree):
    crowded = {}
    for folder in {file.parent for file in python_files(tree)}:
        siblings = [
            item
            for item in folder.iterdir()
            if (item.suffix == ".py" or item.is_dir())
            and item.name not in ("__init__.py", "__pycache__")
        ]
        if len(siblings) > MOST_SIBLINGS:
            crowded[str(folder)] = len(siblings)
    assert crowded == {}


@pytest.mark.parametrize("tree", INNER_IMPORTS)
def test_tests_come_through_the_door(tree):
    imports = inner_imports(tree)
    assert len(imports) <= INNER_IMPORTS[tree], imports


@pytest.mark.parametrize(
    ("text", "modules"),
    [
        ("from ros_pose_stats import estimate", ["ros_pose_stats"]),
        ("from ros_pose_stats.tools import cli", ["ros_pose_stats.tools.cli"]),
        ("from ros_pose_stats.core import mesh", ["ros_pose_stats.core.mesh"]),
        (
            "from ros_pose_stats.core.mesh.hull import hull_of",
            ["ros_pose_stats.core.mesh.hull"],
        ),
    ],
)
def test_imports_of_the_inside_are_seen(text, modules):
    assert weight.imported_modules(ast.parse(text).body[0]) == modules


@pytest.fixture
def small_tree(tmp_path, monkeypatch):
    """A repository whose package is one file, and what its last release weighed."""
    for tree in weight.TREES:
        (tmp_path / tree).mkdir()
        (tmp_path / tree / "module.py").write_text("LIMIT = 1\n")
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs/decisions.md").write_text("# Decisions\n\n## Weight\n\n")
    released = tmp_path / "released.json"
    monkeypatch.setattr(weight, "ROOT", tmp_path)
    monkeypatch.setattr(weight, "RELEASED", released)
    nodes = dict.fromkeys(weight.TREES, len(list(ast.walk(ast.parse("LIMIT = 1\n")))))
    released.write_text(json.dumps({"version": "1.0", "nodes": nodes}))
    return tmp_path


def test_what_is_counted(small_tree):
    (small_tree / PACKAGE / "module.py").write_text(
        "import numpy as np\nimport numba as n\n\n\n"
        "def f(one, part):\n    a, b = part, one\n    found = np.add(a, b)\n"
        f"    return found, n  # {'x' * 80}\n"
    )
    scales = weight.weigh(PACKAGE)
    assert scales.files == 1
    assert scales.code_lines == 6
    assert scales.long_lines == scales.packed == scales.aliases == 1
    assert scales.names == 5
    assert scales.vague == {"one": 1, "found": 1}


def test_a_release_has_three_per_cent_of_room(small_tree, capsys):
    assert weight.main(["--release", "1.1"]) == 0
    assert json.loads(weight.RELEASED.read_text())["version"] == "1.1"
    with (small_tree / PACKAGE / "module.py").open("a") as file:
        file.write("OTHER = 2\n")
    assert weight.main([]) == 0  # of a change it is said, and no more
    assert weight.main(["--release", "1.2"]) == 1
    assert PACKAGE in capsys.readouterr().err
    assert json.loads(weight.RELEASED.read_text())["version"] == "1.1"
    with (small_tree / "docs/decisions.md").open("a") as page:
        page.write("**1.2** has another constant.\n")
    assert weight.main(["--release", "1.2"]) == 0


def test_the_last_release_is_weighed():
    released = json.loads(weight.RELEASED.read_text(encoding="utf-8"))
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## [{released['version']}] - " in changelog
    assert set(released["nodes"]) == set(weight.TREES)
