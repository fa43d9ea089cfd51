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

"""What a reader takes in, by tree: printed by `make lint`, bounded when a version is
released.

    python -m tests.house.weight               the trees beside the last release
    python -m tests.house.weight --release V   the same, kept as what V weighs

A release may weigh 3 % more than the one before, counted in syntax nodes; `--release`
ends with status 1 where a tree weighs more, unless `docs/decisions.md` names the
version under "Weight".
"""

import argparse
import ast
import json
import sys
from collections import Counter
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "ros_pose_stats"
TREES = (PACKAGE, "tests", "lab", "study")
RELEASED = Path(__file__).with_name("released_weight.json")
ROOM = 1.03
COLUMNS = 88

VAGUE = frozenset(
    """
    all alone another any apart aside asked beside both came coming done drawn each
    every few found given gone got held here how it its kept known left made many met
    more much named none now of one ones other own place said same seen sent shown some
    still such taken that them then there these they this those told wanted way what
    when where which who whom whose why about after again ahead among around at before
    behind between by far into near off on once onto out over since so to together too
    twice under until very without yet
    """.split()  # noqa: SIM905 - a list would take a line for each
)
"""Pronouns, participles, prepositions and adverbs: no name of a thing is one of them
alone.
"""

USUAL_ALIASES = frozenset({"numpy", "matplotlib.pyplot"})


class Weight(NamedTuple):
    """Of a tree of Python files."""

    files: int
    nodes: int
    """Syntax nodes: what a reader takes in, however the lines are broken."""
    code_lines: int
    """Lines that are not blank."""
    long_lines: int
    """Of more than 88 columns."""
    packed: int
    """Assignments of a tuple to a tuple, swaps among them."""
    names: int
    """Variables and parameters, at each place that binds them."""
    vague: Counter
    """Those of them that are in `VAGUE`."""
    aliases: int
    """Modules and names imported under another name, numpy and pyplot left out."""


def python_files(tree):
    """The sources below a folder of the repository."""
    return sorted(
        file for file in (ROOT / tree).rglob("*.py") if "__pycache__" not in file.parts
    )


def is_packed(node):
    """Whether a statement assigns several values to several names."""
    return (
        isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Tuple)
        and isinstance(node.value, ast.Tuple)
    )


def bound_names(syntax):
    """Names of variables and parameters of a file's syntax nodes, at each place that
    binds them.
    """
    for node in syntax:
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif isinstance(node, ast.arg):
            yield node.arg


def aliases(syntax):
    """Imports of a file's syntax nodes under another name."""
    for node in imports_of(syntax):
        source = getattr(node, "module", None)
        for alias in node.names:
            full = ".".join(filter(None, (source, alias.name)))
            if alias.asname not in (None, alias.name) and full not in USUAL_ALIASES:
                yield alias


def weigh(tree):
    """Weight of a folder of the repository."""
    nodes = code_lines = long_lines = packed = names = alias_count = 0
    vague = Counter()
    files = python_files(tree)
    for file in files:
        text = file.read_text(encoding="utf-8")
        syntax = list(ast.walk(ast.parse(text)))
        lines = text.splitlines()
        code_lines += sum(bool(line.strip()) for line in lines)
        long_lines += sum(len(line) > COLUMNS for line in lines)
        nodes += len(syntax)
        packed += sum(map(is_packed, syntax))
        bound = list(bound_names(syntax))
        names += len(bound)
        vague.update(name for name in bound if name in VAGUE)
        alias_count += sum(1 for _ in aliases(syntax))
    return Weight(
        len(files), nodes, code_lines, long_lines, packed, names, vague, alias_count
    )


def imports_of(syntax):
    """Import statements among syntax nodes."""
    return [node for node in syntax if isinstance(node, ast.Import | ast.ImportFrom)]


DOORS = {
    PACKAGE,
    f"{PACKAGE}.tools.cli",
    f"{PACKAGE}.base.errors",
    f"{PACKAGE}.core.shapes",
}
"""What tests may import freely: the library, the command, the root of errors, simple
bodies.
"""


def inner_imports(tree):
    """Imports of the product's inside by tests below a folder: (file, line, module)."""
    imports = []
    for file in python_files(tree):
        syntax = ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        for node in imports_of(syntax):
            for module in imported_modules(node):
                if module.split(".")[0] == PACKAGE and not is_door(module):
                    imports.append((str(file.relative_to(ROOT)), node.lineno, module))
    return imports


def is_door(module):
    """Whether a module, or the one that has this name, may be imported freely."""
    return module in DOORS or module.rpartition(".")[0] in DOORS - {PACKAGE}


def imported_modules(node):
    """Modules that an import statement names, those in a package by their own names."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    folder = ROOT / Path(*(node.module or "").split("."))
    submodules = [
        f"{node.module}.{alias.name}"
        for alias in node.names
        if (folder / alias.name).is_dir() or (folder / f"{alias.name}.py").is_file()
    ]
    return submodules or [node.module or ""]


def weigh_trees():
    """Weight of each tree."""
    return {tree: weigh(tree) for tree in TREES}


def print_weights(weights, released):
    """Print a row for each tree, beside the release that was weighed last."""
    print(
        f"{'tree':16}{'files':>6}{'nodes':>9}{'released':>10}{'change':>8}"
        f"{'a line':>8}{'> 88':>6}{'packed':>8}{'vague':>8}{'aliases':>9}"
    )
    for tree, weight in weights.items():
        nodes_before = released["nodes"][tree]
        vague = sum(weight.vague.values()) / max(weight.names, 1)
        print(
            f"{tree:16}{weight.files:6}{weight.nodes:9}{nodes_before:10}"
            f"{weight.nodes / nodes_before - 1.0:8.1%}"
            f"{weight.nodes / max(weight.code_lines, 1):8.1f}{weight.long_lines:6}"
            f"{1000.0 * weight.packed / max(weight.code_lines, 1):8.1f}"
            f"{vague:8.1%}{weight.aliases:9}"
        )
    print(
        f"released: {released['version']}; nodes a line; lines over {COLUMNS} columns; "
        "packed assignments a thousand lines; names that are no nouns"
    )


def too_heavy(weights, released):
    """Trees that weigh more than a release may."""
    return [
        tree
        for tree, weight in weights.items()
        if weight.nodes > ROOM * released["nodes"][tree]
    ]


def is_explained(version):
    """Whether the page of decisions says what a user gets for the weight of a
    version.
    """
    page = (ROOT / "docs/decisions.md").read_text(encoding="utf-8")
    section = page.partition("\n## Weight\n")[2].partition("\n## ")[0]
    return version in section


def main(arguments=None):
    """Print the table; keep it where a version is released."""
    parser = argparse.ArgumentParser(prog="tests.house.weight", description=__doc__)
    parser.add_argument("--release", metavar="VERSION", help="keep it as a release")
    version = parser.parse_args(arguments).release
    released = json.loads(RELEASED.read_text(encoding="utf-8"))
    weights = weigh_trees()
    print_weights(weights, released)
    if version is None:
        return 0
    if (heavy := too_heavy(weights, released)) and not is_explained(version):
        print(
            f"more than {ROOM - 1.0:.0%} heavier than {released['version']}: "
            f"{', '.join(heavy)}; say in docs/decisions.md, under Weight, what a user "
            f"of {version} gets for it",
            file=sys.stderr,
        )
        return 1
    nodes = {tree: weight.nodes for tree, weight in weights.items()}
    RELEASED.write_text(
        json.dumps({"version": version, "nodes": nodes}, indent=2) + "\n",
        encoding="utf-8",
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
