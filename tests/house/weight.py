"""What the project weighs: lines, files and imports by tree, words of pages, by one command.

    python -m tests.house.weight

`PROCESS_STARTS` of the tests are counted while they run, by the hook in `tests/conftest.py`.
"""

import ast
from collections import Counter
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]


class Weight(NamedTuple):
    """Of a tree of Python files."""

    files: int
    lines: int
    imports: int
    """Lines of import statements."""


def python_files(tree):
    """The sources below a folder of the repository."""
    return sorted(
        file for file in (ROOT / tree).rglob("*.py") if "__pycache__" not in file.parts
    )


def imports_of(module):
    """Import statements of a parsed file."""
    return [
        node
        for node in ast.walk(module)
        if isinstance(node, ast.Import | ast.ImportFrom)
    ]


def weigh(tree):
    """Weight of a folder of the repository."""
    lines = imports = 0
    files = python_files(tree)
    for file in files:
        text = file.read_text(encoding="utf-8")
        lines += text.count("\n")
        imports += sum(
            node.end_lineno - node.lineno + 1 for node in imports_of(ast.parse(text))
        )
    return Weight(len(files), lines, imports)


PACKAGE = "ros_pose_stats"
DOORS = {PACKAGE, f"{PACKAGE}.cli", f"{PACKAGE}.errors", f"{PACKAGE}.shapes"}
"""What tests may import freely: the library, the command, the root of errors, simple bodies."""


def inner_imports(tree):
    """Imports of the product's inside by tests below a folder: (file, line, module)."""
    met = []
    for file in python_files(tree):
        for node in imports_of(ast.parse(file.read_text(encoding="utf-8"))):
            modules = (
                [alias.name for alias in node.names]
                if isinstance(node, ast.Import)
                else [node.module or ""]
            )
            if isinstance(node, ast.ImportFrom) and node.module in DOORS:
                modules = [
                    f"{node.module}.{alias.name}"
                    for alias in node.names
                    if (ROOT / PACKAGE / alias.name).is_dir()
                    and f"{PACKAGE}.{alias.name}" not in DOORS
                ]
            met += [
                (str(file.relative_to(ROOT)), node.lineno, module)
                for module in modules
                if module.split(".")[0] == PACKAGE and module not in DOORS
            ]
    return met


MEASURED = ROOT / "docs" / "measured"
PRINTED = (ROOT / "docs" / "commands.md",)
"""Pages that a program writes, beside those in `docs/measured`."""


def words_of_people():
    """Words of each page that a person wrote, by its path."""
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    return {
        str(page.relative_to(ROOT)): len(page.read_text(encoding="utf-8").split())
        for page in sorted(pages)
        if page not in PRINTED and MEASURED not in page.parents
    }


def main():
    """Print the tables."""
    print(f"{'tree':22}{'files':>7}{'lines':>8}{'imports %':>11}")
    trees = [
        *sorted(
            str(folder.relative_to(ROOT))
            for top in (PACKAGE, "tests", "lab", "study")
            for folder in (ROOT / top, *(ROOT / top).iterdir())
            if folder.is_dir() and python_files(folder)
        )
    ]
    for tree in trees:
        weight = weigh(tree)
        print(
            f"{tree:22}{weight.files:7}{weight.lines:8}"
            f"{100.0 * weight.imports / max(weight.lines, 1):11.1f}"
        )
    inner = inner_imports("tests")
    print(f"\nimports of the product's inside by tests: {len(inner)}")
    folders = Counter("/".join(file.split("/")[:3]) for file, *_ in inner)
    for folder, count in folders.most_common():
        print(f"{folder:40}{count:6}")
    words = words_of_people()
    print(f"\nwords of pages that people wrote: {sum(words.values())}")
    for page, count in sorted(words.items(), key=lambda item: -item[1]):
        print(f"{page:40}{count:6}")


if __name__ == "__main__":
    main()
