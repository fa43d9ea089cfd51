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

"""Every room imports lower floors only, and heavy libraries stay in the rooms that need
them.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import ros_pose_stats
from tests.house.imports import Import, Sources

PACKAGE = Path(ros_pose_stats.__file__).resolve().parent

FLOORS = {
    "": (
        {"base"},
        {"core"},
        {"node"},
        {"tools"},
        {"__main__"},
    ),
    "core": (
        {"tolerances"},
        {"records"},
        {"kernels"},
        {"mesh", "statistics"},
        {"resting"},
        {"estimators", "simulation", "shapes"},
        {"planning", "plates"},
    ),
    "core.mesh": ({"bodies"},),
    "core.kernels": ({"mesh", "drops"}, {"body"}, {"levels"}, {"features"}),
    "node": (
        {"messages", "recording"},
        {"settings", "state"},
        {"parts"},
        {"jobs"},
        {"services"},
        {"examples"},
    ),
    "node.recording": ({"writer"},),
    "tools": (
        {"bags", "batch", "design"},
        {"plots"},
        {"report"},
        {"catalogue", "watching"},
        {"commands"},
        {"cli"},
    ),
    "tools.commands": ({"terminal", "tables"},),
}
"""What stands on what inside a folder, from below.

A module that is not listed lies between the rooms of its folder, wherever it must;
every folder is listed, and of the package itself every module.
"""

ROOMS_OF = {
    "numpy": ("",),
    "numba": ("core.kernels",),
    "llvmlite": ("core.kernels",),
    "scipy": (
        "core.statistics",
        "core.mesh",
        "core.resting",
        "core.planning",
        "core.plates",
        "tools.design",
    ),
    "trimesh": ("core.mesh", "core.shapes"),
    "cascadio": ("core.mesh",),
    "manifold3d": ("core.mesh", "core.resting", "core.shapes"),
    "yaml": ("core.plates", "node"),
    "mcap": ("node.recording", "tools.bags"),
    "mcap_ros2": ("node.recording", "tools.bags"),
    "zstandard": ("node.recording",),
    "lz4": ("node.recording",),
    "matplotlib": ("tools.plots",),
    "PIL": ("tools.plots",),
    "jinja2": ("tools.report",),
    "shtab": ("tools.commands",),
    "distributed": ("tools.batch",),
    "pyarrow": ("tools.catalogue",),
}
"""Where a library may be imported; one that is missing here, only in `node`."""


def is_in(module: str, room: str) -> bool:
    """Whether a module, seen from the package, is a room or lies in it."""
    return not room or module == room or module.startswith(f"{room}.")


def climbs(arrow: Import, sources: Sources) -> bool:
    """Whether an import goes up, or sideways into another room of the same floor."""
    importer = arrow.importer.split(".")[1:]
    target = arrow.target.split(".")[1:]
    if importer[:2] == ["node", "examples"] and not target:
        return (
            False  # written as users write theirs, who import the package's own names
        )
    depth = 0
    while importer[depth : depth + 1] == target[depth : depth + 1] != []:
        depth += 1
    folder = ".".join(importer[:depth])
    floor_of = {
        room: floor
        for floor, rooms in enumerate(FLOORS.get(folder, ()))
        for room in rooms
    }
    if depth == len(target):  # a folder's own `__init__`, by what lies in it
        return not folder
    if depth == len(importer):  # what an `__init__` exports lies in its folder
        return False
    importer_floor = floor_of.get(importer[depth])
    target_floor = floor_of.get(target[depth])
    return (
        importer_floor is not None
        and target_floor is not None
        and target_floor >= importer_floor
    )


def climbing(sources: Sources) -> list[str]:
    """Imports that go up, or sideways into another room."""
    return [str(arrow) for arrow in sources.internal if climbs(arrow, sources)]


def misplaced(sources: Sources) -> list[str]:
    """Imports of a library outside its rooms."""
    return [
        str(arrow)
        for arrow in sources.third_party
        if not arrow.typing
        and not any(
            is_in(arrow.importer.partition(".")[2], room)
            for room in ROOMS_OF.get(arrow.target.partition(".")[0], ("node",))
        )
    ]


def unlisted(sources: Sources) -> set[str]:
    """Folders, and modules of the package itself, that have no floor."""
    rooms = {
        room
        for module in sources.files
        for room in (
            module.partition(".")[2].rpartition(".")[0],
            *[module.partition(".")[2]] * (module.count(".") == 1),
        )
        if room
    }
    return {
        room
        for room in rooms
        if not any(
            room.rpartition(".")[2] in floor
            for floor in FLOORS.get(room.rpartition(".")[0], ())
        )
    }


@pytest.fixture(scope="module")
def sources() -> Sources:
    return Sources(PACKAGE)


class TestThisPackage:
    def test_every_room_has_a_floor(self, sources):
        assert unlisted(sources) == set()

    def test_no_room_imports_a_higher_floor_or_a_sibling(self, sources):
        assert climbing(sources) == []

    def test_no_import_cycles(self, sources):
        assert sources.cycles() == []

    def test_libraries_stay_in_their_rooms(self, sources):
        assert misplaced(sources) == []

    def test_the_walk_sees_the_package(self, sources):
        arrows = {(arrow.importer, arrow.target) for arrow in sources.imports}
        commands = "ros_pose_stats.tools.commands"
        assert ("ros_pose_stats.tools.cli", f"{commands}.terminal.arguments") in arrows
        assert (
            f"{commands}.estimate",
            "ros_pose_stats.core.estimators.estimate",
        ) in arrows
        assert ("ros_pose_stats.core.kernels.machine_code", "numba") in arrows


def test_the_picture_shows_the_imports(sources):
    """`python -m tests.house.architecture_picture` draws it anew."""
    # It draws the floors that stand here.
    from tests.house.architecture_picture import PICTURE, draw

    assert PICTURE.read_text(encoding="utf-8") == draw(sources)


class TestTheWalkItself:
    """On small packages that break each rule once."""

    @staticmethod
    def package(folder: Path, modules: dict[str, str]) -> Sources:
        root = folder / "sample"
        for name, text in modules.items():
            file = root / f"{name}.py"
            file.parent.mkdir(parents=True, exist_ok=True)
            for parent in file.relative_to(root).parents:
                (root / parent / "__init__.py").touch()
            file.write_text(text)
        return Sources(root)

    @pytest.mark.parametrize(
        "text",
        [
            "from ...tools.report import page",
            "from sample.tools.report import page",
            "from ...tools import report",
            "import sample.tools.report.page",
            "def late():\n    from ...tools.report.page import write",
            "try:\n    import sample.tools.report\nexcept ImportError:\n    pass",
            "from ... import compare",
        ],
    )
    def test_climbing_between_wings_is_found(self, tmp_path, text):
        sources = self.package(
            tmp_path, {"core/mesh/hull": text, "tools/report/page": ""}
        )
        assert len(climbing(sources)) == 1

    def test_a_sibling_room_is_found(self, tmp_path):
        sources = self.package(
            tmp_path,
            {
                "core/kernels/fast": "from ..statistics import t",
                "core/statistics/t": "",
            },
        )
        assert len(climbing(sources)) == 1

    def test_own_room_and_lower_floors_pass(self, tmp_path):
        sources = self.package(
            tmp_path,
            {
                "base/errors": "",
                "core/mesh/a": "from . import b",
                "core/mesh/b": "from ...base.errors import E",
                "node/examples/planner": "from sample import estimate",
            },
        )
        assert climbing(sources) == []
        assert sources.cycles() == []

    def test_what_only_type_checkers_see_climbs_and_makes_a_cycle(self, tmp_path):
        sources = self.package(
            tmp_path,
            {
                "tools/report/page": "from ...core.mesh import b",
                "core/mesh/b": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n"
                "    from ...tools.report import page\nelse:\n    page = None",
            },
        )
        assert len(climbing(sources)) == 1
        assert len(sources.cycles()) == 1

    def test_climbing_between_folders_of_a_room_is_found(self, tmp_path):
        sources = self.package(
            tmp_path,
            {
                "node/node": "from .jobs import job\nfrom .messages import times",
                "node/messages/times": "from .. import node\nfrom ..jobs.job import J",
                "node/jobs/job": "from ..messages import times",
                "core/kernels/body/hull": "from ..levels.tree import merge",
                "core/kernels/levels/tree": "from ..body import other",
                "core/kernels/body/other": "",
            },
        )
        assert [line.split(":")[0] for line in climbing(sources)] == [
            "sample.core.kernels.body.hull",
            "sample.node.messages.times",
        ]

    def test_a_room_without_a_floor_is_found(self, tmp_path):
        sources = self.package(tmp_path, {"core/kernels/new/a": "", "leftover": ""})
        assert unlisted(sources) == {"core.kernels.new", "leftover"}

    def test_cycles_are_found(self, tmp_path):
        sources = self.package(
            tmp_path,
            {
                "core/mesh/a": "from .b import y",
                "core/mesh/b": "from .c import z",
                "core/mesh/c": "def f():\n    from . import a",
                "core/mesh/d": "import sample.core.mesh.a",
            },
        )
        assert sources.cycles() == [
            [f"sample.core.mesh.{name}" for name in "abc"],
        ]

    @pytest.mark.parametrize(
        ("room", "text"),
        [
            ("core/mesh", "import numba"),
            ("core/estimators", "from scipy import stats"),
            ("tools/report", "import matplotlib.pyplot as plt"),
            ("tools/commands", "import rclpy.node"),
            ("tools/commands", "import trimesh"),
            ("core/kernels", "import pandas"),
            ("core/statistics", "def f():\n    from mcap.writer import Writer"),
        ],
    )
    def test_misplaced_libraries_are_found(self, tmp_path, room, text):
        assert len(misplaced(self.package(tmp_path, {f"{room}/a": text}))) == 1


def test_what_the_checkout_imports_of_its_own_is_there(sources):
    trees = {name: Sources(PACKAGE.parent / name) for name in ("tests", "study", "lab")}
    trees[PACKAGE.name] = sources
    missing = [
        str(arrow)
        for tree in trees.values()
        for arrow in tree.imports
        if (home := trees.get(arrow.target.partition(".")[0])) is not None
        and arrow.target not in home.files
    ]
    assert missing == []
