"""Outlines of the parsers as plain records, for docs/commands.md."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass

from ros_pose_stats.commands.arguments import CommandParser


@dataclass(frozen=True)
class ArgumentOutline:
    """An option, or a positional argument."""

    flags: tuple[str, ...]  # `-o`, `--output`; empty for a positional argument
    values: tuple[str, ...]  # placeholder for each value; empty for a flag without values
    most: float  # largest number of values; infinite where they are repeated
    choices: tuple[str, ...]  # the only values accepted; none where they are free
    required: bool
    about: str  # its help, with the defaults filled in

    @property
    def shown_values(self) -> str:
        """The values as they stand behind an option: `X Y Z`, `m|mm|cm|inch`, `R ...`."""
        return " ".join([*self.values, *(["..."] if math.isinf(self.most) else [])])


@dataclass(frozen=True)
class CommandOutline:
    """A command, or the whole command line."""

    words: tuple[str, ...]  # what is typed: the program and the command
    summary: str  # its line in the list of commands; empty for the whole
    description: str
    epilog: str
    arguments: tuple[ArgumentOutline, ...]  # options but for `--help`, and positional arguments
    alternatives: tuple[tuple[ArgumentOutline, ...], ...]  # options of which only one may be given
    takes_ros_arguments: bool  # whether `--ros-args` may follow
    examples: tuple[str, ...]
    commands: tuple[CommandOutline, ...]  # the commands below it

    def walk(self) -> Iterator[CommandOutline]:
        """The command and all below it."""
        yield self
        for command in self.commands:
            yield from command.walk()


def outline_command(parser: argparse.ArgumentParser, summary: str = "") -> CommandOutline:
    """Describe a parser and all parsers below it.

    `summary`: its line in the list of commands.
    """
    arguments: dict[str, ArgumentOutline] = {}
    commands: list[CommandOutline] = []
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            summaries = {line.dest: line.help or "" for line in action._choices_actions}
            commands += [outline_command(command, summaries.get(name, ""))
                         for name, command in action.choices.items()]
        elif not isinstance(action, argparse._HelpAction):
            arguments[action.dest] = _outline_argument(action, parser.prog)
    return CommandOutline(
        words=tuple(parser.prog.split()), summary=summary,
        description=parser.description or "", epilog=parser.epilog or "",
        arguments=tuple(arguments.values()),
        alternatives=tuple(
            tuple(arguments[action.dest] for action in group._group_actions)
            for group in parser._mutually_exclusive_groups),
        takes_ros_arguments=bool(parser.get_default("takes_ros_arguments")),
        examples=parser.examples if isinstance(parser, CommandParser) else (),
        commands=tuple(commands))


def _outline_argument(action: argparse.Action, program: str) -> ArgumentOutline:
    if action.nargs == 0:
        names: tuple[str, ...] = ()
    elif isinstance(action.metavar, tuple):
        names = action.metavar
    else:
        named = action.metavar or "|".join(map(str, action.choices or ())) or action.dest.upper()
        names = (named,) * (action.nargs if isinstance(action.nargs, int) else 1)
    return ArgumentOutline(
        flags=tuple(action.option_strings), values=names,
        most=math.inf if action.nargs in ("+", "*") else len(names),
        choices=tuple(map(str, action.choices or ())),
        required=action.required,
        about=(action.help or "") % {**vars(action), "prog": program})
