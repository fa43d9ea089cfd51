"""What the project weighs is bounded, and the bounds are lowered, never raised.

A bound that must rise has an entry in `docs/decisions.md` that says what a user gets for it.
"""

from collections import defaultdict

import pytest

from tests.house.imports import Sources
from tests.house.weight import (
    PACKAGE,
    ROOT,
    inner_imports,
    python_files,
    weigh,
    words_of_people,
)

LINES = {"ros_pose_stats": 34_407, "ros_pose_stats/node": 5_997, "tests": 23_901}
FILES = {"ros_pose_stats": 233, "ros_pose_stats/node": 39, "tests": 215}
IMPORTS = {"ros_pose_stats": 0.06, "ros_pose_stats/node": 0.085, "tests": 0.07}
"""Share of the lines."""

MOST_SIBLINGS = 20
"""Files and folders in a folder; the package itself holds the rooms."""

ROOMS = 26
ONE_IMPORTER = 60
"""Modules of the package that one other imports."""

WORDS = 23_300
"""Of pages that people wrote; what programs write is in `docs/measured`."""

INNER_IMPORTS = {"tests/contract": 0, "tests/golden": 3}
"""Imports of the product's inside by tests: users have none, golden makes its parts by three."""


@pytest.mark.parametrize("tree", LINES)
def test_lines_files_and_imports(tree):
    weight = weigh(tree)
    assert weight.lines <= LINES[tree]
    assert weight.files <= FILES[tree]
    assert weight.imports <= IMPORTS[tree] * weight.lines


@pytest.mark.parametrize("tree", LINES)
def test_no_folder_is_crowded(tree):
    folders = {file.parent for file in python_files(tree)}
    crowded = {
        str(folder): count
        for folder in folders
        if (
            count := sum(
                item.suffix == ".py" or item.is_dir()
                for item in folder.iterdir()
                if item.name not in ("__init__.py", "__pycache__")
            )
        )
        > (ROOMS if folder.name == PACKAGE else MOST_SIBLINGS)
    }
    assert crowded == {}


def test_few_modules_have_one_importer():
    sources = Sources(ROOT / PACKAGE)
    importers = defaultdict(set)
    for one in sources.internal:
        if sources.files[one.target].name != "__init__.py":
            importers[one.target].add(one.importer)
    assert sum(len(who) == 1 for who in importers.values()) <= ONE_IMPORTER


@pytest.mark.parametrize("tree", INNER_IMPORTS)
def test_tests_come_through_the_door(tree):
    met = inner_imports(tree)
    assert len(met) <= INNER_IMPORTS[tree], met


def test_words_of_people():
    words = words_of_people()
    assert "README.md" in words and "docs/decisions.md" in words
    assert sum(words.values()) <= WORDS, words
