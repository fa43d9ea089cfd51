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

"""Which modules a package imports, read from its sources without running them."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Import:
    """One imported module: by whom, at which line, and its full dotted name."""

    importer: str
    line: int
    target: str
    typing: bool = False
    """Whether it is under `if TYPE_CHECKING:` and never runs."""

    def __str__(self) -> str:
        return f"{self.importer}:{self.line} imports {self.target}"


class Sources:
    """A package's modules and what they import.

    Imports inside functions count, and those under `if TYPE_CHECKING:`, marked as such.
    """

    def __init__(self, package: Path) -> None:
        self.name = package.name
        self.files = {
            self._dotted(package, file): file for file in package.rglob("*.py")
        }
        self.imports = [
            import_ for module in sorted(self.files) for import_ in self._read(module)
        ]

    @staticmethod
    def _dotted(package: Path, file: Path) -> str:
        parts = file.relative_to(package.parent).with_suffix("").parts
        return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)

    @property
    def internal(self) -> list[Import]:
        """Imports of the package's own modules."""
        return [arrow for arrow in self.imports if arrow.target in self.files]

    @property
    def third_party(self) -> list[Import]:
        """Imports from outside the package and the standard library."""
        return [
            arrow
            for arrow in self.imports
            if arrow.target not in self.files
            and arrow.target.partition(".")[0] not in sys.stdlib_module_names
        ]

    def _read(self, module: str) -> Iterator[Import]:
        tree = ast.parse(self.files[module].read_text(encoding="utf-8"))
        for statement, typing in _import_statements(tree):
            if isinstance(statement, ast.Import):
                for alias in statement.names:
                    yield Import(module, statement.lineno, alias.name, typing)
            elif isinstance(statement, ast.ImportFrom):
                for target in self._targets(module, statement):
                    yield Import(module, statement.lineno, target, typing)

    def _targets(self, module: str, statement: ast.ImportFrom) -> set[str]:
        """The submodules among the imported names, and the module itself for all
        others.
        """
        base = statement.module or ""
        if statement.level:
            is_package = self.files[module].name == "__init__.py"
            parts = module.split(".")
            parts = parts[: len(parts) - statement.level + is_package]
            base = ".".join([*parts, base] if base else parts)
        names = {f"{base}.{alias.name}" for alias in statement.names}
        modules = names & self.files.keys()
        return modules | ({base} if names - modules else set())

    def cycles(self) -> list[list[str]]:
        """Groups of modules that import each other, also for type checkers (Tarjan's
        strong components).
        """
        onward: dict[str, set[str]] = {module: set() for module in self.files}
        for arrow in self.internal:
            onward[arrow.importer].add(arrow.target)
        number: dict[str, int] = {}
        lowest: dict[str, int] = {}
        stack: list[str] = []
        groups: list[list[str]] = []

        def visit(module: str) -> None:
            number[module] = lowest[module] = len(number)
            stack.append(module)
            for target in sorted(onward[module]):
                if target not in number:
                    visit(target)
                if target in stack:
                    lowest[module] = min(lowest[module], lowest[target])
            if lowest[module] == number[module]:
                group = stack[stack.index(module) :]
                del stack[stack.index(module) :]
                if len(group) > 1 or module in onward[module]:
                    groups.append(sorted(group))

        for module in sorted(self.files):
            if module not in number:
                visit(module)
        return groups


def _import_statements(tree: ast.AST) -> Iterator[tuple[ast.AST, bool]]:
    """Imports of a file, each with whether it is under `if TYPE_CHECKING:`."""
    syntax = list(ast.walk(tree))
    typing = {
        inner
        for node in syntax
        if isinstance(node, ast.If) and _is_type_checking(node.test)
        for statement in node.body
        for inner in ast.walk(statement)
    }
    for node in syntax:
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield node, node in typing


def _is_type_checking(test: ast.expr) -> bool:
    return (isinstance(test, ast.Name) and test.id == "TYPE_CHECKING") or (
        isinstance(test, ast.Attribute) and test.attr == "TYPE_CHECKING"
    )
