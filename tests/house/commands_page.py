"""Writes docs/commands.md from the parsers: `python -m tests.house.commands_page`."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

from ros_pose_stats.cli import parser
from tests.house.outlines import ArgumentOutline, CommandOutline, outline_command

PAGE = Path(__file__).resolve().parents[2] / "docs" / "commands.md"
WIDTH = 96

HEAD = """\
# Commands

<!-- `python -m tests.house.commands_page` writes this page; change the text in the parsers. -->

`ros_pose_stats` is one program with a command for each thing that it does; `python -m
ros_pose_stats` is the same. `ros_pose_stats COMMAND --help` prints what stands here about a
command, and `ros_pose_stats --version` prints the version. Only `node`, `publish`
and `show` need ROS.

"""

COMMON = """\

## What holds for all commands

**Numbers.** Counts and seeds may be typed as `100000` or `1e5`. A length is a number of metres, or
has its unit: `200mm`. Probabilities and errors are fractions between 0 and 1.

**Files.** A part is read from a STEP, STL, OBJ, PLY, OFF or 3MF file. STL, OBJ, PLY and OFF do
not say their unit: it is guessed from the size, and a warning says so unless `--unit` is given.
STEP files need the package cascadio, which `make setup` installs; all solids of a file are one
part. The examples use the parts that `ros_pose_stats shapes demo` writes.

**JSON.** With `--json` a command prints JSON and nothing else on standard output. NaN and infinity
are written as `null`.

**Exit status.** 0 if all went well; 2 for an input that is refused, with one line on standard
error that says what was expected, what came and what to do; 130 after Ctrl-C; 1 for an internal
failure or an output that cannot be written.

**Ctrl-C.** A command that drops parts stops within a moment and reports what it has done; in the
JSON stands `"interrupted": true`. A second Ctrl-C ends it at once.
"""


MORE = {"estimate": ("measured/split", "hybrid", "warnings"), "simulate": ("simulation",),
        "report": ("report",), "catalogue": ("catalogue",), "dataset": ("datasets",),
        "benchmark": ("measured/accuracy", "measured/stability"), "fit": ("plates",),
        "sensitivity": ("design", "measured/design"), "compare": ("design",),
        "bag": ("bags",), "node": ("node",)}
"""Pages that say more about a command."""


def commands_page(top: CommandOutline) -> str:
    """The whole page."""
    lines = ["| command | what it does |", "|---|---|"]
    lines += [f"| [`{one.words[-1]}`](#{one.words[-1]}) | {one.summary} |" for one in top.commands]
    sections = [line for command in top.commands for line in _section(command, "##")]
    return HEAD + "\n".join([*lines, COMMON, *sections[1:], ""])


def _section(command: CommandOutline, level: str) -> Iterator[str]:
    yield from ("", f"{level} {' '.join(command.words[1:])}", "", _wrapped(command.description))
    if pages := MORE.get(" ".join(command.words[1:])):
        linked = ", ".join(f"[{page}.md]({page}.md)" for page in pages)
        yield from ("", f"More: {linked}.")
    if not command.commands:
        yield from ("", "```", *_synopsis(command), "```")
    if command.arguments:
        yield from ("", "| argument | meaning |", "|---|---|")
        for one in command.arguments:
            yield f"| {_shown(one)} | {_cell(one.about)} |"
    if command.epilog:
        yield from ("", _wrapped(command.epilog))
    yield from ("", "For example:", "", "```sh", *command.examples, "```")
    for kind in command.commands:
        yield from _section(kind, level + "#")


def _synopsis(command: CommandOutline) -> list[str]:
    """What may be typed: first what must be there."""
    pieces = [one.shown_values for one in command.arguments if not one.flags]
    pieces += [_option(one) for one in command.arguments if one.flags and one.required]
    told = {one for group in command.alternatives for one in group}
    optional = [(one,) for one in command.arguments
                if one.flags and not one.required and one not in told]
    pieces += [f"[{' | '.join(map(_option, group))}]"
               for group in (*optional, *command.alternatives)]
    if command.takes_ros_arguments:
        pieces.append("[--ros-args ...]")
    # A piece is not broken, so its own spaces are hidden from the wrapping.
    text = " ".join(piece.replace(" ", "\0") for piece in pieces)
    program = " ".join(command.words) + " "
    lines = textwrap.wrap(text, WIDTH - len(program), break_long_words=False,
                          break_on_hyphens=False)
    return [f"{program if k == 0 else ' ' * len(program)}{line}".replace("\0", " ").rstrip()
            for k, line in enumerate(lines or [""])]


def _option(one: ArgumentOutline) -> str:
    return " ".join(filter(None, [one.flags[0], one.shown_values]))


def _shown(one: ArgumentOutline) -> str:
    if not one.flags:
        return f"`{_cell(one.shown_values)}`"
    return ", ".join(f"`{_cell(' '.join(filter(None, [flag, one.shown_values])))}`"
                     for flag in one.flags)


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


def _wrapped(text: str) -> str:
    return textwrap.fill(text, WIDTH, break_long_words=False, break_on_hyphens=False)


def main() -> int:
    """Write the page."""
    PAGE.write_text(commands_page(outline_command(parser())), encoding="utf-8")
    print(PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
