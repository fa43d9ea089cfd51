"""`completion SHELL`: a script that completes commands, options and their values on Tab."""

from __future__ import annotations

import argparse
import math
import shlex
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .outlines import ArgumentOutline, CommandOutline

SHELLS = ("bash", "zsh")

ANY = 1000
"""Number that stands for any number of values of an option."""

ROS_OPTIONS = ("-p", "-r", "--params-file")
"""Options that are offered behind --ros-args."""


def register(commands: argparse._SubParsersAction[argparse.ArgumentParser],
             top: argparse.ArgumentParser) -> None:
    """Add the command, which reads all parsers below `top` when it runs."""
    command = commands.add_parser(
        "completion", help="print a script that completes commands and options on Tab",
        description="Print a script for the shell that completes commands, options, their "
        "choices and file names when Tab is pressed. For bash, add the line "
        "`source <(ros_pose_stats completion bash)` to `~/.bashrc`. For zsh, write the script to "
        "a file `_ros_pose_stats` in a directory of `$fpath`, or add the line "
        "`source <(ros_pose_stats completion zsh)` to `~/.zshrc` behind `compinit`.",
        examples=("ros_pose_stats completion bash",))
    command.add_argument("shell", choices=SHELLS, help="the shell: bash or zsh")
    command.set_defaults(run=partial(run, top))


def run(top: argparse.ArgumentParser, options: argparse.Namespace) -> int:
    """Print the script."""
    from .outlines import outline_command

    script = bash_script if options.shell == "bash" else zsh_script
    print(script(outline_command(top)), end="")
    return 0


BASH = """\
# Completion for bash, printed by `ros_pose_stats completion bash`.

# What a command offers: the commands below it, its options, and values that go by their place.
_ros_pose_stats_words() {
    case $1 in
@WORDS@
    esac
}

# How many values an option takes, and which.
_ros_pose_stats_values() {
    case $1 in
@VALUES@
    esac
}

_ros_pose_stats() {
    local word=${COMP_WORDS[COMP_CWORD]} command=ros_pose_stats k
    local commands= options= values= paths= most=0 choices= files= ros=
    COMPREPLY=()
    for ((k = 1; k < COMP_CWORD; k++)); do
        _ros_pose_stats_words "$command"
        [[ ${COMP_WORDS[k]} == --ros-args && $options == *--ros-args* ]] && ros=1
        [[ " $commands " == *" ${COMP_WORDS[k]} "* ]] && command+=" ${COMP_WORDS[k]}"
    done
    _ros_pose_stats_words "$command"
    if [[ $ros ]]; then
        options='@ROS@' values= paths=
        [[ ${COMP_WORDS[COMP_CWORD - 1]} == --params-file ]] && options= paths=1
    else
        # The option to which the word may belong is the nearest before it.
        for ((k = COMP_CWORD - 1; k > 0; k--)); do
            [[ ${COMP_WORDS[k]} == -* && ! ${COMP_WORDS[k]} =~ ^-[0-9.] ]] && break
        done
        # bash makes three words of --unit=mm.
        local first=$((k + 1))
        [[ ${COMP_WORDS[first]} == = ]] && first=$((first + 1))
        [[ $word == = ]] && word=
        if ((k > 0)); then
            _ros_pose_stats_values "$command ${COMP_WORDS[k]}"
            if ((COMP_CWORD - first < most)); then
                # Behind the last one that must be there, options may follow.
                ((most < @ANY@ || COMP_CWORD == first)) && options=
                commands= values=$choices paths=$files
            fi
        fi
    fi
    if [[ $word == -* || ! $values$paths$commands ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
    elif [[ $paths ]]; then
        # Outside of a completion, as in a test, there is nothing to set.
        compopt -o filenames 2>/dev/null
        mapfile -t COMPREPLY < <(compgen -f -- "$word")
    else
        mapfile -t COMPREPLY < <(compgen -W "$commands $values" -- "$word")
    fi
}

complete -F _ros_pose_stats ros_pose_stats
"""


def bash_script(top: CommandOutline) -> str:
    """The script for bash."""
    words, values = [], []
    for command in top.walk():
        name = " ".join(command.words)
        flags = ["--help", *(flag for one in command.arguments for flag in one.flags),
                 *(["--ros-args"] if command.takes_ros_arguments else [])]
        placed = [one for one in command.arguments if not one.flags]
        words.append(
            f"        '{name}') commands={_quoted(one.words[-1] for one in command.commands)}"
            f" options={_quoted(flags)} values={_quoted(c for one in placed for c in one.choices)}"
            f" paths={'1' if any(one.is_path for one in placed) else ''} ;;")
        for one in command.arguments:
            if one.flags and one.most:
                cases = "|".join(f"'{name} {flag}'" for flag in one.flags)
                most = ANY if math.isinf(one.most) else int(one.most)
                values.append(f"        {cases}) most={most} choices={_quoted(one.choices)} "
                              f"files={'1' if one.is_path else ''} ;;")
    return (BASH.replace("@WORDS@", "\n".join(words)).replace("@VALUES@", "\n".join(values))
            .replace("@ROS@", " ".join(ROS_OPTIONS)).replace("@ANY@", str(ANY)))


def _quoted(words: Iterable[str]) -> str:
    line = " ".join(words)
    return shlex.quote(line) if line else ""


def zsh_script(top: CommandOutline) -> str:
    """The script for zsh."""
    functions = "\n".join(_zsh_function(command) for command in top.walk())
    return ("#compdef ros_pose_stats\n"
            "# Completion for zsh, printed by `ros_pose_stats completion zsh`.\n\n"
            f"{functions}\n"
            "# Called by compinit's own function, or sourced by ~/.zshrc.\n"
            'if [[ $funcstack[1] == _ros_pose_stats ]]; then\n'
            '    _ros_pose_stats "$@"\n'
            "else\n"
            "    compdef _ros_pose_stats ros_pose_stats\n"
            "fi\n")


def _zsh_function(command: CommandOutline) -> str:
    lines = ["'(- *)'{-h,--help}'[show the help and exit]'",
             *(_zsh_option(one) for one in command.arguments if one.flags),
             *(_zsh_place(one) for one in command.arguments if not one.flags)]
    if command.takes_ros_arguments:
        lines.append("'--ros-args[arguments for ROS follow]:*:ROS argument:_files'")
    if not command.commands:
        return _zsh_body(command, "_arguments", lines, "")
    described = " ".join(_zsh_quote(f"{one.words[-1]}:{_one_line(one.summary)}")
                         for one in command.commands)
    branches = "\n".join(f"            {one.words[-1]}) {_function_name(one)} ;;"
                         for one in command.commands)
    after = f"""\
    case $state in
        command)
            local -a commands=({described})
            _describe command commands ;;
        argument)
            case $words[1] in
{branches}
            esac ;;
    esac
"""
    return _zsh_body(command,
                     "local curcontext=$curcontext state line\n"
                     "    typeset -A opt_args\n    _arguments -C",
                     [*lines, "'1:command:->command'", "'*::argument:->argument'"], after)


def _zsh_body(command: CommandOutline, call: str, lines: list[str], after: str) -> str:
    listed = " \\\n        ".join([call, *lines])
    return f"{_function_name(command)}() {{\n    {listed}\n{after}}}\n"


def _function_name(command: CommandOutline) -> str:
    return "_" + "_".join(command.words)


def _zsh_option(one: ArgumentOutline) -> str:
    about = _one_line(one.about).replace("[", r"\[").replace("]", r"\]")
    values = "".join(f":{name.lower()}:{_zsh_action(one)}" for name in one.values)
    if math.isinf(one.most):
        # zsh would take all that follows for values of this option.
        values = f":{one.values[0].lower()}:{_zsh_action(one)}"
    excluded = " ".join(one.flags)
    return " ".join(
        _zsh_quote(f"({excluded}){flag}{_zsh_joint(one, flag)}[{about}]{values}")
        for flag in one.flags)


def _zsh_joint(one: ArgumentOutline, flag: str) -> str:
    """The sign that a value may stand behind an equals sign, too."""
    return "=" if flag.startswith("--") and one.most == 1 else ""


def _zsh_place(one: ArgumentOutline) -> str:
    place = "*" if math.isinf(one.most) else ""
    return _zsh_quote(f"{place}:{one.values[0].lower()}:{_zsh_action(one)}")


def _zsh_action(one: ArgumentOutline) -> str:
    if one.choices:
        return f"({' '.join(one.choices)})"
    return "_files" if one.is_path else " "


def _one_line(text: str) -> str:
    return " ".join(text.split()).replace(":", r"\:")


def _zsh_quote(text: str) -> str:
    return "'" + text.replace("'", "'\\''") + "'"
