"""Every room imports lower floors only, and heavy libraries stay in the rooms that need them."""

from __future__ import annotations

from pathlib import Path

import pytest

import ros_pose_stats
from tests.house.imports import Sources

PACKAGE = Path(ros_pose_stats.__file__).resolve().parent

FLOORS = (
    {"errors", "methods", "text", "tolerances", "version"},
    {"records", "files"},
    {"kernels", "statistics"},
    {"mesh"},
    {"resting"},
    {"estimators", "simulation", "shapes"},
    {"planning", "plates"},
    {"design"},
    {"recording"},
    {"batch", "plots"},
    {"report"},
    {"catalogue"},
    {"ros", "commands", "cli", "__main__"},
)
FLOOR = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}
FLOOR[""] = len(FLOORS)  # the package's own __init__, which no module may import

NEIGHBOURS = {("cli", "commands"), ("__main__", "cli"), ("commands", "ros")}
"""Rooms of one floor that may be imported all the same."""

INNER_FLOORS = {
    "kernels": ({"mesh", "drops"}, {"body"}, {"levels"}, {"features"}),
    "recording": ({"writer"}, {"analysis"}),
    "ros": ({"messages"}, {"state"}, {"parts"}, {"jobs"}, {"services"}, {"examples"}),
    "commands": ({"bags"}, {"feeding"}),
}
"""Folders of a room, which are rooms inside it; its own modules may be anywhere between them."""

STILL_CLIMBING = {
    ("kernels", "body", "levels"),
}
"""Arrows that go up today. None may be added, and one that is gone leaves this list."""

ROOMS_OF = {
    "numpy": set(FLOOR),
    "numba": {"kernels"},
    "llvmlite": {"kernels"},
    "scipy": {"statistics", "mesh", "resting", "planning", "plates", "design"},
    "trimesh": {"mesh", "shapes"},
    "cascadio": {"mesh"},
    "manifold3d": {"mesh", "resting", "shapes"},
    "yaml": {"plates"},
    "mcap": {"recording"},
    "mcap_ros2": {"recording"},
    "zstandard": {"recording"},
    "matplotlib": {"plots"},
    "PIL": {"plots"},
    "jinja2": {"report"},
    "shtab": {"commands"},
    "rclpy": {"ros"},
    "distributed": {"batch"},
    "pyarrow": {"catalogue"},
}
"""Where a library may be imported; one that is missing here, only in `ros`."""


EXAMPLES = "ros_pose_stats.ros.examples."
"""Written as users write theirs, who import the package's own names."""


def climbing(sources: Sources) -> list[str]:
    """Imports that go up, or sideways into another room."""
    found = []
    for one in sources.internal:
        here = sources.room(one.importer)
        there = sources.room(one.target)
        if here == there or (here, there) in NEIGHBOURS:
            continue
        if one.importer.startswith(EXAMPLES) and not there:
            continue
        if FLOOR[there] >= FLOOR[here]:
            found.append(str(one))
    return found


def climbing_inside(sources: Sources) -> set[tuple[str, str, str]]:
    """Imports that go up between the folders of a room: room, from where, to where."""
    met = set()
    for one in sources.internal:
        room = sources.room(one.importer)
        here = sources.inner_room(one.importer)
        there = sources.inner_room(one.target)
        if room == sources.room(one.target) and here and there and here != there:
            floor = {
                name: number
                for number, names in enumerate(INNER_FLOORS.get(room, ()))
                for name in names
            }
            if floor.get(there, 0) >= floor.get(here, 0):
                met.add((room, here, there))
    return met


def misplaced(sources: Sources) -> list[str]:
    """Imports of a library outside its rooms."""
    return [
        str(one)
        for one in sources.third_party
        if not one.typing
        and sources.room(one.importer)
        not in ROOMS_OF.get(one.target.partition(".")[0], {"ros"})
    ]


@pytest.fixture(scope="module")
def sources() -> Sources:
    return Sources(PACKAGE)


class TestThisPackage:
    def test_every_room_has_a_floor(self, sources):
        assert {sources.room(module) for module in sources.files} <= FLOOR.keys()

    def test_no_room_imports_a_higher_floor_or_a_sibling(self, sources):
        assert [one for one in climbing(sources) if not one.startswith(EXAMPLES)] == []

    def test_every_folder_of_a_room_has_a_floor(self, sources):
        folders = {
            (sources.room(module), sources.inner_room(module))
            for module in sources.files
        }
        assert {(room, folder) for room, folder in folders if folder} == {
            (room, folder)
            for room, floors in INNER_FLOORS.items()
            for folder in set().union(*floors)
        }

    def test_no_folder_of_a_room_imports_one_above_it_or_beside_it(self, sources):
        assert climbing_inside(sources) == STILL_CLIMBING

    def test_no_import_cycles(self, sources):
        assert sources.cycles() == []

    def test_libraries_stay_in_their_rooms(self, sources):
        assert misplaced(sources) == []

    def test_the_walk_sees_the_package(self, sources):
        seen = {(one.importer, one.target) for one in sources.imports}
        assert ("ros_pose_stats.cli", "ros_pose_stats.commands.estimate") in seen
        assert (
            "ros_pose_stats.commands.estimate",
            "ros_pose_stats.estimators.estimate",
        ) in seen
        assert ("ros_pose_stats.kernels.machine_code", "numba") in seen


class TestTheWalkItself:
    """On small packages that break each rule once."""

    @staticmethod
    def package(folder: Path, modules: dict[str, str]) -> Sources:
        root = folder / "sample"
        for name, text in modules.items():
            file = root / f"{name}.py"
            file.parent.mkdir(parents=True, exist_ok=True)
            (file.parent / "__init__.py").touch()
            file.write_text(text)
        return Sources(root)

    @pytest.mark.parametrize(
        "text",
        [
            "from ..report import page",
            "from sample.report import page",
            "from .. import report",
            "import sample.report.page",
            "def late():\n    from ..report.page import write",
            "try:\n    import sample.report\nexcept ImportError:\n    pass",
        ],
    )
    def test_climbing_is_found(self, tmp_path, text):
        found = self.package(tmp_path, {"mesh/hull": text, "report/page": ""})
        assert len(climbing(found)) == 1

    def test_a_sibling_room_is_found(self, tmp_path):
        found = self.package(
            tmp_path, {"kernels/fast": "from ..statistics import t", "statistics/t": ""}
        )
        assert len(climbing(found)) == 1

    def test_own_room_and_lower_floors_pass(self, tmp_path):
        found = self.package(
            tmp_path,
            {
                "errors": "",
                "mesh/a": "from . import b",
                "mesh/b": "from ..errors import E",
            },
        )
        assert climbing(found) == []
        assert found.cycles() == []

    def test_what_only_type_checkers_see_climbs_but_makes_no_cycle(self, tmp_path):
        found = self.package(
            tmp_path,
            {
                "report/page": "from ..mesh import b",
                "mesh/b": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n"
                "    from ..report import page\nelse:\n    page = None",
            },
        )
        assert len(climbing(found)) == 1
        assert found.cycles() == []

    def test_climbing_between_folders_of_a_room_is_found(self, tmp_path):
        found = self.package(
            tmp_path,
            {
                "ros/node": "from .jobs import job\nfrom .messages import times",
                "ros/messages/times": "from .. import node\nfrom ..jobs.job import J",
                "ros/jobs/job": "from ..messages import times",
                "ros/parts/store": "",
                "recording/writer/bag_file": "from ..analysis.bag_reader import read_bags",
                "recording/analysis/bag_reader": "",
            },
        )
        assert climbing_inside(found) == {
            ("ros", "messages", "jobs"),
            ("recording", "writer", "analysis"),
        }

    def test_cycles_are_found(self, tmp_path):
        found = self.package(
            tmp_path,
            {
                "mesh/a": "from .b import y",
                "mesh/b": "from .c import z",
                "mesh/c": "def f():\n    from . import a",
                "mesh/d": "import sample.mesh.a",
            },
        )
        assert found.cycles() == [["sample.mesh.a", "sample.mesh.b", "sample.mesh.c"]]

    @pytest.mark.parametrize(
        ("room", "text"),
        [
            ("mesh", "import numba"),
            ("estimators", "from scipy import stats"),
            ("report", "import matplotlib.pyplot as plt"),
            ("commands", "import rclpy.node"),
            ("commands", "import trimesh"),
            ("kernels", "import pandas"),
            ("statistics", "def f():\n    from mcap.writer import Writer"),
        ],
    )
    def test_misplaced_libraries_are_found(self, tmp_path, room, text):
        assert len(misplaced(self.package(tmp_path, {f"{room}/a": text}))) == 1


@pytest.mark.parametrize("tree", ["study", "lab"])
def test_what_programs_of_the_checkout_import_is_there(tree, sources):
    missing = [
        str(one)
        for one in Sources(PACKAGE.parent / tree).imports
        if one.target.startswith(f"{PACKAGE.name}.") and one.target not in sources.files
    ]
    assert missing == []
