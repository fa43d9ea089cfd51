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

"""Writes docs/commands.md from the parsers: `python -m tests.house.commands_page`."""

import argparse
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

from ros_pose_stats.tools.cli import parser
from ros_pose_stats.tools.commands.terminal.arguments import CommandParser

PAGE = Path(__file__).resolve().parents[2] / "docs" / "commands.md"
WIDTH = 96

HEAD = """\
# Commands

<!-- `python -m tests.house.commands_page` writes this from the parsers' text. -->

`ros_pose_stats` is one program with a command for each thing that it does; `python -m
ros_pose_stats` is the same. `ros_pose_stats COMMAND --help` prints what stands here
about a command, and `ros_pose_stats --version` prints the version. Only `node`,
`publish` and `show` need ROS.

"""

COMMON = """\

## What holds for all commands

**Numbers.** Counts and seeds may be typed as `100000` or `1e5`. A length is a number of
metres, or has its unit: `200mm`. Probabilities and errors are fractions between 0 and
1.

**Files.** A part is read from a STEP, STL, OBJ, PLY, OFF or 3MF file. STL, OBJ, PLY and
OFF do not say their unit: up to a largest extent of 0.6 it is the metre, else the
millimetre, and a warning says so unless `--unit` is given. `publish` refuses such a
file without `--unit`. STEP files need the package cascadio, which `make setup`
installs. Bodies of a file that stand apart are parts of their own: of equal ones one is
taken, of different ones `--body N` says which, and `--body all` takes all as one rigid
part. The examples use the parts that `ros_pose_stats shapes demo` writes.

**JSON.** With `--json` a command prints JSON and nothing else on standard output. NaN
and infinity are written as `null`.

**Exit status.** 0 if all went well; 2 for an input that is refused, with one line on
standard error that says what was expected, what came and what to do; 130 after Ctrl-C;
1 for an internal failure or an output that cannot be written.

**Ctrl-C.** What drops parts, but `report`, `animate` and `fit`, stops within a moment
and reports what has been done, in JSON with `"interrupted": true`. A second Ctrl-C ends
it at once.
"""


MORE = {
    "estimate": ("split", "hybrid", "warnings"),
    "simulate": ("simulation",),
    "report": ("report",),
    "catalogue": ("catalogue",),
    "fit": ("plates",),
    "sensitivity": ("design", "measured/design"),
    "compare": ("design",),
    "bag": ("bags",),
    "node": ("node",),
}
"""Pages that say more about a command."""


def commands_page(top: argparse.ArgumentParser) -> str:
    """The whole page."""
    (subparsers,) = [
        action
        for action in top._actions
        if isinstance(action, argparse._SubParsersAction)
    ]
    lines = ["| command | what it does |", "|---|---|"]
    lines += [
        f"| [`{choice.dest}`](#{choice.dest}) | {choice.help} |"
        for choice in subparsers._choices_actions
    ]
    sections = [
        line
        for name, command in subparsers.choices.items()
        for line in _section(name, command)
    ]
    return HEAD + "\n".join([*lines, COMMON, *sections[1:], ""])


def _section(name: str, command: CommandParser) -> Iterator[str]:
    yield from ("", f"## {name}", "", _wrapped(command.description or ""))
    if pages := MORE.get(name):
        linked = ", ".join(f"[{page}.md]({page}.md)" for page in pages)
        yield from ("", f"More: {linked}.")
    arguments = {
        action.dest: action
        for action in command._actions
        if not isinstance(action, argparse._HelpAction)
    }
    yield from ("", "```", *_synopsis(command, list(arguments.values())), "```")
    if arguments:
        yield from ("", "| argument | meaning |", "|---|---|")
        for action in arguments.values():
            help_text = (action.help or "") % {**vars(action), "prog": command.prog}
            yield f"| {_shown(action)} | {_cell(help_text)} |"
    if command.epilog:
        yield from ("", _wrapped(command.epilog))
    yield from ("", "For example:", "", "```sh", *command.examples, "```")


def _synopsis(command: CommandParser, arguments: list[argparse.Action]) -> list[str]:
    """What may be typed: first what must be there."""
    pieces = [
        f"[{_values(action)}]" if action.nargs == "?" else _values(action)
        for action in arguments
        if not action.option_strings
    ]
    pieces += [
        _option(action)
        for action in arguments
        if action.option_strings and action.required
    ]
    exclusive = command._mutually_exclusive_groups
    pieces += [
        f"({' | '.join(map(_option, group._group_actions))})"
        for group in exclusive
        if group.required
    ]
    groups = [group._group_actions for group in exclusive if not group.required]
    grouped = [action for group in exclusive for action in group._group_actions]
    optional = [
        [action]
        for action in arguments
        if action.option_strings and not action.required and action not in grouped
    ]
    pieces += [f"[{' | '.join(map(_option, group))}]" for group in (*optional, *groups)]
    if command.get_default("takes_ros_arguments"):
        pieces.append("[--ros-args ...]")
    # A piece is not broken, so its own spaces are hidden from the wrapping.
    text = " ".join(piece.replace(" ", "\0") for piece in pieces)
    program = f"{command.prog} "
    lines = textwrap.wrap(
        text, WIDTH - len(program), break_long_words=False, break_on_hyphens=False
    )
    return [
        f"{program if k == 0 else ' ' * len(program)}{line}".replace("\0", " ").rstrip()
        for k, line in enumerate(lines or [""])
    ]


def _values(action: argparse.Action) -> str:
    """The values as they stand behind an option: `X Y Z`, `m|mm|cm|inch`, `R ...`."""
    if action.nargs == 0:
        return ""
    if isinstance(action.metavar, tuple):
        return " ".join(action.metavar)
    metavar = (
        action.metavar
        or "|".join(map(str, action.choices or ()))
        or action.dest.upper()
    )
    repeated = " ..." if action.nargs in ("+", "*") else ""
    return (
        " ".join([metavar] * (action.nargs if isinstance(action.nargs, int) else 1))
        + repeated
    )


def _option(action: argparse.Action) -> str:
    return " ".join(filter(None, [action.option_strings[0], _values(action)]))


def _shown(action: argparse.Action) -> str:
    if not action.option_strings:
        return f"`{_cell(_values(action))}`"
    return ", ".join(
        f"`{_cell(' '.join(filter(None, [flag, _values(action)])))}`"
        for flag in action.option_strings
    )


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


def _wrapped(text: str) -> str:
    return textwrap.fill(text, WIDTH, break_long_words=False, break_on_hyphens=False)


def main() -> int:
    """Write the page."""
    PAGE.write_text(commands_page(parser()), encoding="utf-8")
    print(PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
