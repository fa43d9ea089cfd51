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

"""docs/designing.md: its scripts save a bracket, and its command says what it shows."""

import re
import shlex

import pytest

from tests.running import ROOT

from .watching import WatchingCommand

PAGE = (ROOT / "docs" / "designing.md").read_text(encoding="utf-8")
SCRIPTS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
(TERMINAL,) = re.findall(r"```text\n(.*?)```", PAGE, re.DOTALL)
SHARES = re.findall(r"^\| \d \| .* \| ([\d.]+ %) \|$", PAGE, re.MULTILINE)


@pytest.fixture
def scripts(tmp_path, monkeypatch):
    """The scripts of the page, to be run in their order; the first has run."""
    monkeypatch.chdir(tmp_path)
    names = {}

    def run(script):
        exec(compile(script, "page", "exec"), names)

    run(SCRIPTS[0])
    return [lambda script=script: run(script) for script in SCRIPTS[1:]]


@pytest.fixture
def watching(scripts, tmp_path):
    """The first command of the page."""
    line = re.search(r"^ros_pose_stats report .*$", PAGE, re.MULTILINE)[0]
    _, _, file, *options = shlex.split(line)
    command = WatchingCommand(tmp_path / file, *options)
    yield command
    assert command.end() == (0, "")


def without_time(line):
    """A line of the terminal without the time of day."""
    return line.partition("  ")[2]


def test_the_terminal_says_of_each_save_what_the_page_shows(scripts, watching):
    first, *others = map(without_time, TERMINAL.splitlines())
    assert list(map(without_time, watching.first_lines)) == [first]
    assert len(others) == len(scripts)
    for save, line in zip(scripts, others, strict=True):
        save()
        assert without_time(watching.line()) == line


@pytest.mark.long
def test_drops_find_the_shares_of_the_table(scripts, watching):
    for save, share in zip([None, *scripts], SHARES, strict=True):
        if save is not None:
            save()
            watching.line()
        news = watching.news()
        while not re.search(r"by \d+ drops?<", news["html"]):
            news = watching.news(news["number"], news["version"])
        assert news["title"].startswith(f"{share} accepted")
