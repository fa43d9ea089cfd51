"""The help of every command, and its examples, which run."""

from __future__ import annotations

import shlex
import subprocess
import sys

import pytest

from ros_pose_stats import cli
from ros_pose_stats.commands.outlines import outline_command
from tests.running import complaints

WHOLE = outline_command(cli.parser())
COMMANDS = {" ".join(one.words): one for one in WHOLE.walk()}
EXAMPLES = [(one, line) for one in COMMANDS.values() for line in one.examples]

NOT_RUN = {
    "bag": "there are no bags in the user's directory",
    "node": "it runs until it is ended", "publish": "it runs until it is ended",
    "benchmark": "most of its kinds take minutes",
    "fit": "there are no counts in the user's directory",
}
"""Commands whose examples are only parsed here, and why."""

ONE_AFTER_ANOTHER = ["shapes", "estimate", "simulate", "catalogue", "flips", "compare",
                     "sensitivity", "report", "animate", "compile", "completion"]
"""The others: the first makes the parts that the others read."""


def test_the_walk_sees_all_commands():
    assert {"ros_pose_stats", "ros_pose_stats estimate", "ros_pose_stats benchmark table",
            "ros_pose_stats bag"} < COMMANDS.keys()


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_ends_with_the_examples(name, capsys):
    with pytest.raises(SystemExit) as exit_:
        cli.main([*name.split()[1:], "--help"])
    assert exit_.value.code == 0
    out = capsys.readouterr().out
    examples = COMMANDS[name].examples
    assert examples
    title = "example" if len(examples) == 1 else "examples"
    assert out.endswith("\n".join([f"\n\n{title}:", *(f"  {line}" for line in examples), ""]))


@pytest.mark.parametrize(("command", "line"), EXAMPLES, ids=[line for _, line in EXAMPLES])
def test_the_parser_accepts_the_example_as_one_of_that_command(command, line):
    program, *words = shlex.split(line)
    assert program == "ros_pose_stats"
    ours, rest = cli._split(words)
    parsed = cli.parser().parse_args(ours)
    assert not rest or parsed.takes_ros_arguments
    if not command.commands:
        assert line.split()[:len(command.words)] == list(command.words)


@pytest.mark.parametrize(("name", "command"), COMMANDS.items(), ids=COMMANDS)
def test_every_argument_is_explained(name, command):
    for argument in command.arguments:
        assert argument.about, argument
        assert "%" not in argument.about.replace("90 %", ""), argument
    assert command.description
    assert command.summary or command is COMMANDS["ros_pose_stats"]


@pytest.mark.parametrize("name", ["node", "publish"])
def test_a_usage_that_is_written_by_hand_names_every_option(name):
    (parser,) = [one for one in _parsers(cli.parser()) if one.prog.endswith(name)]
    for argument in COMMANDS[f"ros_pose_stats {name}"].arguments:
        shown = f"[{argument.flags[0]} " if argument.flags else argument.shown_values
        assert shown in parser.usage
    assert "--ros-args" in parser.usage


def _parsers(parser):
    (commands,) = (action for action in parser._actions if action.dest == "command")
    return commands.choices.values()


@pytest.mark.long
def test_examples_run(tmp_path):
    kinds = {line.split()[1] for _, line in EXAMPLES}
    assert kinds == {*ONE_AFTER_ANOTHER, *NOT_RUN, "dataset"}
    for name in ONE_AFTER_ANOTHER:
        for line in COMMANDS[f"ros_pose_stats {name}"].examples:
            run(line, tmp_path)


@pytest.mark.long
def test_the_dataset_is_made_and_compared_by_the_examples(tmp_path):
    for name in ("dataset", "benchmark table"):
        for line in COMMANDS[f"ros_pose_stats {name}"].examples:
            run(line, tmp_path)


def run(line, folder):
    done = subprocess.run([sys.executable, "-m", *shlex.split(line)], cwd=folder,
                          capture_output=True, text=True)
    assert (done.returncode, complaints(done.stderr)) == (0, []), line
    assert done.stdout
