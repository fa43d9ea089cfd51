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

"""Habits of the tests that keep them quick, steady and free of the product's inside."""

import ast
from functools import cache

import pytest

from tests.house.weight import PACKAGE, python_files

TREES = ("tests", "lab")

GROUPING = ("np.unique", "set", "frozenset", "tuple", "Counter", "Counter.update")
"""What takes equal values together, or makes a key of them."""

NAMED_TUPLE = ("_fields", "_replace", "_asdict", "_make")
"""Public names of every NamedTuple."""


@cache
def syntax_of(tree):
    """Files of a tree, each with all nodes of its syntax."""
    return [
        (file, nodes_of(file.read_text(encoding="utf-8")))
        for file in python_files(tree)
    ]


def nodes_of(text):
    return list(ast.walk(ast.parse(text)))


def names_of_product(nodes):
    """Local names in a file that stand for the product or something in it."""
    return {
        alias.asname or alias.name.split(".")[0]
        for node in nodes
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
        if (
            node.module or "" if isinstance(node, ast.ImportFrom) else alias.name
        ).split(".")[0]
        == PACKAGE
    }


def patches(nodes):
    """Lines that put something of their own into a module of the product."""
    ours = names_of_product(nodes)
    for node in nodes:
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Attribute)
            and node.func.attr in ("setattr", "delattr", "patch", "object")
            and node.args
        ):
            target = node.args[0]
            root = next(
                (part for part in ast.walk(target) if isinstance(part, ast.Name)), None
            )
            if (root is not None and root.id in ours) or (
                isinstance(target, ast.Constant)
                and str(target.value).startswith(PACKAGE)
            ):
                yield node.lineno


def private_names(nodes):
    """Lines that read a private name of the product."""
    ours = names_of_product(nodes)
    for node in nodes:
        if (
            isinstance(node, ast.ImportFrom)
            and (node.module or "").split(".")[0] == PACKAGE
        ):
            if any(
                alias.name.startswith("_") and not alias.name.endswith("__")
                for alias in node.names
            ):
                yield node.lineno
        elif (
            isinstance(node, ast.Attribute)
            and node.attr.startswith("_")
            and not node.attr.endswith("__")
            and node.attr not in NAMED_TUPLE
            and isinstance(node.value, ast.Name)
            and node.value.id in ours
        ):
            yield node.lineno


def rounded_keys(nodes):
    """Lines that compare or look up values that are rounded to a decimal."""

    def rounds(node):
        return isinstance(node, ast.Call) and (
            (
                isinstance(node.func, ast.Name)
                and node.func.id == "round"
                and len(node.args) == 2
            )
            or (
                isinstance(node.func, ast.Attribute)
                and node.func.attr == "round"
                and (
                    len(node.args) == 2
                    or (len(node.args) == 1 and isinstance(node.args[0], ast.Constant))
                )
            )
        )

    if not any(map(rounds, nodes)):
        return
    for node in nodes:
        parts = (
            node.ops and [node.left, *node.comparators]
            if isinstance(node, ast.Compare)
            else [node.slice]
            if isinstance(node, ast.Subscript)
            else [*filter(None, node.keys)]
            if isinstance(node, ast.Dict)
            else [node.key]
            if isinstance(node, ast.DictComp)
            else [node.elt]
            if isinstance(node, ast.SetComp)
            else node.args
            if isinstance(node, ast.Call) and ast.unparse(node.func) in GROUPING
            else []
        )
        if any(rounds(inner) for part in parts for inner in ast.walk(part)):
            yield node.lineno


def test_no_file_has_a_habit():
    places_with_habits = [
        f"{file}:{line}"
        for tree in TREES
        for file, nodes in syntax_of(tree)
        for habit in (patches, private_names, rounded_keys)
        for line in habit(nodes)
    ]
    assert places_with_habits == []


@pytest.mark.parametrize(
    ("habit", "text"),
    [
        (
            patches,
            "from ros_pose_stats.core.mesh import hull\n"
            "m.setattr(hull, 'ConvexHull', 1)",
        ),
        (patches, "m.setattr('ros_pose_stats.core.mesh.hull.ConvexHull', 1)"),
        (private_names, "from ros_pose_stats.core.mesh.hull import _faces"),
        (private_names, "import ros_pose_stats\nros_pose_stats._HOMES"),
        (rounded_keys, "assert round(x, 3) == y"),
        (rounded_keys, "np.unique(np.round(x, 7), axis=0)"),
    ],
)
def test_the_habits_are_seen(habit, text):
    assert len(list(habit(nodes_of(text)))) == 1


TESTS_IN_LAB = (
    "tests.contract.node.harness",
    "tests.contract.pages.browser",
    "tests.contract.pages.watching",
)
LAB_IN_TESTS = ("lab.bodies",)
"""What the lab needs of the tests, a node with its client and a page with its browser,
and what tests need of it."""


def imported_modules(tree, wing):
    """Modules of a wing that the files of a tree import, but for the tests of that
    wing.
    """
    for file, nodes in syntax_of(tree):
        if "house" in file.parts:
            continue
        for node in nodes:
            if isinstance(node, ast.Import):
                modules = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and not node.level:
                modules = [f"{node.module}.{alias.name}" for alias in node.names]
            else:
                continue
            for module in modules:
                if module.split(".")[0] == wing:
                    yield f"{file}:{node.lineno}: {module}"


@pytest.mark.parametrize(
    ("tree", "wing", "doors"),
    [
        ("tests", "lab", LAB_IN_TESTS),
        ("tests", "study", ()),
        ("lab", "tests", TESTS_IN_LAB),
        ("study", "tests", ()),
    ],
)
def test_lab_and_tests_share_bodies_and_nothing_else(tree, wing, doors):
    imports = [
        line
        for line in imported_modules(tree, wing)
        if not line.rpartition(" ")[2].startswith(doors or ("-",))
    ]
    assert imports == []
