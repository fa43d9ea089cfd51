"""The scripts of `completion`, run by the shells that they are for."""

from __future__ import annotations

import os
import pty
import re
import shlex
import shutil
import subprocess
import sys
import time

import pytest

from ros_pose_stats import cli
from ros_pose_stats.commands.outlines import outline_command
from tests.running import ROOT, answer, command

WHOLE = outline_command(cli.parser())


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    """The two scripts, and files to complete the names of."""
    folder = tmp_path_factory.mktemp("completion")
    for shell in ("bash", "zsh"):
        (folder / f"script.{shell}").write_text(answer("completion", shell))
    (folder / "cad").mkdir()
    for name in ("clamp.stl", "clamp two.stl", "gear.stl"):
        (folder / "cad" / name).touch()
    return folder


def test_another_shell_is_refused():
    done = command("completion", "fish")
    assert done.returncode == 2
    assert "bash" in done.stderr and done.stderr.count("\n") == 1


def test_the_script_is_printed_without_loading_numpy():
    code = ("import sys; from ros_pose_stats import cli\n"
            "cli.main(['completion', 'bash'])\nprint('numpy' in sys.modules)")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert done.stdout.splitlines()[-1] == "False"


BASH = shutil.which("bash")


@pytest.mark.skipif(BASH is None, reason="there is no bash")
class TestBash:
    @pytest.fixture
    def complete(self, scripts):
        """What bash offers for the last of the words."""
        def offered(*words):
            lines = ["set -u", "source script.bash",
                     f"COMP_WORDS=({' '.join(map(shlex.quote, ('ros_pose_stats', *words)))})",
                     f"COMP_CWORD={len(words)}", "_ros_pose_stats",
                     "printf '%s\\n' \"${COMPREPLY[@]}\""]
            done = subprocess.run([BASH, "--norc", "-c", "\n".join(lines)], cwd=scripts,
                                  capture_output=True, text=True)
            assert (done.returncode, done.stderr) == (0, "")
            return [line for line in done.stdout.splitlines() if line]

        return offered

    def test_it_is_registered_for_the_command(self, scripts):
        done = subprocess.run([BASH, "--norc", "-c", "source script.bash; complete -p"],
                              cwd=scripts, capture_output=True, text=True)
        assert done.stdout == "complete -F _ros_pose_stats ros_pose_stats\n"

    def test_commands(self, complete):
        names = [one.words[-1] for one in WHOLE.commands]
        assert complete("") == names
        assert complete("es") == ["estimate"]
        assert complete("co") == ["compare", "compile", "completion"]
        assert complete("benchmark", "") == ["table", "prisms", "chart", "stability", "plates",
                                              "figures"]
        assert complete("--v") == ["--version"]

    @pytest.mark.parametrize("outline", [one for one in WHOLE.walk() if not one.commands],
                             ids=lambda one: " ".join(one.words))
    def test_all_options_of_every_command(self, complete, outline):
        found = complete(*outline.words[1:], "-")
        assert set(found) - {"--ros-args"} == {
            "--help", *(flag for one in outline.arguments for flag in one.flags)}
        assert ("--ros-args" in found) == outline.takes_ros_arguments

    @pytest.mark.parametrize("outline", [one for one in WHOLE.walk() if not one.commands],
                             ids=lambda one: " ".join(one.words))
    def test_choices_and_files_behind_every_option(self, complete, outline):
        for one in outline.arguments:
            for flag in one.flags if one.most else ():
                expected = list(one.choices) or (["cad/gear.stl"] if one.is_path else [])
                begun = "cad/g" if one.is_path else ""
                assert complete(*outline.words[1:], flag, begun) == expected, flag

    def test_values_that_are_begun(self, complete):
        assert complete("estimate", "a.stl", "--method", "h") == ["hybrid"]
        assert complete("estimate", "a.stl", "--unit", "=") == ["m", "mm", "cm", "inch", "auto"]
        assert complete("estimate", "a.stl", "--unit", "=", "i") == ["inch"]
        assert complete("completion", "z") == ["zsh"]

    def test_file_names(self, complete):
        clamps = ["cad/clamp.stl", "cad/clamp two.stl"]
        assert sorted(complete("estimate", "cad/c")) == sorted(clamps)
        assert sorted(complete("estimate", "--unit", "mm", "cad/c")) == sorted(clamps)
        assert complete("estimate", "--json", "cad/g") == ["cad/gear.stl"]
        assert complete("benchmark", "table", "--dataset", "a.npz", "cad/g") == ["cad/gear.stl"]

    def test_numbers_are_left_to_the_user(self, complete):
        assert complete("estimate", "--com", "1", "-2", "") == []
        assert complete("estimate", "--drops", "") == []
        assert complete("estimate", "--com", "1", "-2", "3", "cad/g") == ["cad/gear.stl"]
        assert complete("report", "--wanted", "") == []
        assert "-o" in complete("report", "--wanted", "0", "-")

    def test_ros_arguments(self, complete):
        assert complete("node", "--ros-args", "-") == ["-p", "-r", "--params-file"]
        assert complete("node", "--ros-args", "--params-file", "cad/g") == ["cad/gear.stl"]
        assert complete("publish", "a.stl", "--ros-args", "--p") == ["--params-file"]

    def test_a_name_with_a_space_is_quoted_at_the_prompt(self, scripts):
        """In an interactive shell, where `compopt` has its effect."""
        shown = type_into([BASH, "--norc", "--noprofile", "-i"], scripts,
                          ["PS1=; bind 'set bell-style none'", "source script.bash"],
                          "ros_pose_stats estimate cad/clamp\\ t\t", "two.stl")
        assert r"cad/clamp\ two.stl" in shown


ZSH = shutil.which("zsh")


@pytest.mark.skipif(ZSH is None, reason="there is no zsh")
class TestZsh:
    def test_the_syntax(self, scripts):
        done = subprocess.run([ZSH, "-n", "script.zsh"], cwd=scripts, capture_output=True,
                              text=True)
        assert (done.returncode, done.stderr) == (0, "")

    @pytest.mark.parametrize(("typed", "completed"), [
        ("ros_pose_stats est\t", "estimate"),
        ("ros_pose_stats benchmark pri\t", "prisms"),
        ("ros_pose_stats benchmark prisms --dice\t", "--dice-drops"),
        ("ros_pose_stats estimate a.stl --unit in\t", "inch"),
        ("ros_pose_stats estimate a.stl --method=hy\t", "hybrid"),
        ("ros_pose_stats estimate --json cad/ge\t", "gear.stl"),
        ("ros_pose_stats report a.stl --output cad/ge\t", "gear.stl"),
        ("ros_pose_stats node --ros\t", "--ros-args")])
    def test_what_the_prompt_completes(self, scripts, typed, completed):
        shown = type_into([ZSH, "-f", "-i"], scripts,
                          ["PS1=; unsetopt beep zle_bracketed_paste", "autoload -U compinit",
                           "compinit -u -D", "source script.zsh"], typed, completed)
        assert completed in shown.rpartition("ros_pose_stats ")[2]


def type_into(shell, folder, lines, typed, awaited):
    """What a terminal shows after some lines and a last one that is not entered."""
    terminal, end = pty.openpty()
    running = subprocess.Popen(
        shell, cwd=folder, stdin=end, stdout=end, stderr=end, start_new_session=True,
        env=os.environ | {"TERM": "dumb", "COLUMNS": "200", "HISTFILE": ""})
    os.close(end)
    try:
        os.write(terminal, "\n".join([*lines, "echo rea''dy", ""]).encode())
        read_until(terminal, "[\r\n]ready")
        os.write(terminal, typed.encode())
        return read_until(terminal, re.escape(awaited))
    finally:
        running.kill()
        running.wait()
        os.close(terminal)


def read_until(terminal, awaited):
    """What the terminal shows up to some text, or in ten seconds."""
    shown, end = "", time.monotonic() + 10.0
    os.set_blocking(terminal, False)
    while not re.search(awaited, shown) and time.monotonic() < end:
        try:
            shown += os.read(terminal, 4096).decode(errors="replace")
        except BlockingIOError:
            time.sleep(0.02)
    return shown
