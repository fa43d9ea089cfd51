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

"""Progress on a terminal, and Ctrl-C: what has been done is reported, with exit status
130.
"""

import contextlib
import io
import signal

import pytest

from ros_pose_stats.tools import cli
from tests.running import strict_json

ENDLESS = 10**8


class Terminal(io.StringIO):
    """Standard error that people watch; Ctrl-C comes as soon as it shows some words."""

    def __init__(self, words):
        super().__init__()
        self.words = words

    def isatty(self):
        return True

    def write(self, text):
        if self.words and self.words in text:
            self.words = None
            signal.raise_signal(signal.SIGINT)
        return super().write(text)


def interrupted(words, *arguments):
    """Standard output and error of a command that Ctrl-C ends."""
    printed = io.StringIO()
    terminal = Terminal(words)
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(terminal):
        assert cli.main([str(word) for word in arguments]) == 130
    assert terminal.words is None
    return printed.getvalue(), terminal.getvalue()


@pytest.fixture(scope="module")
def bar(box):
    """Of a run that ends as a table."""
    return interrupted("left, error", "simulate", *box, "--drops", ENDLESS)


def test_drops_rate_time_left_and_error_are_shown_and_wiped_away(bar):
    text, progress = bar
    assert (
        f"of {ENDLESS} drops, " in progress
        and "/s, " in progress
        and " points" in progress
    )
    assert all(len(line) < 80 for line in progress.split("\r"))
    assert progress.endswith(" \r")
    assert "\r" not in text and f"of {ENDLESS} drops" in text.splitlines()[-1]
    assert text.splitlines()[-1].startswith("interrupted after ")


@pytest.mark.parametrize(
    ("command", "options"),
    [
        ("simulate", ("--drops", ENDLESS)),
        ("estimate", ("--target-error", 0.00001)),
    ],
)
def test_drops_so_far_are_reported(box, command, options):
    text, _ = interrupted("left, error", command, *box, *options, "--seed", 3, "--json")
    values = strict_json(text)
    assert values["interrupted"] is True and 0 < values["drops"] < ENDLESS
    if command == "simulate":
        assert sum(pose["count"] for pose in values["poses"]) == values["drops"]


@pytest.mark.parametrize(
    ("command", "options"),
    [
        # At such a restitution a drop takes so long that no look at the drops ends the
        # comparison.
        ("compare", ("--drops", ENDLESS, "--restitution", 0.9995)),
        ("sensitivity", ("--drops", ENDLESS, "--wanted", 2)),
        ("flips", ("--kick", 0.05, "--flips", ENDLESS)),
    ],
)
def test_other_commands_that_drop_say_that_they_were_interrupted(box, command, options):
    files = [box[0], *box] if command == "compare" else box
    text, _ = interrupted(
        "[", command, *files, *options, "--seed", 1, "--workers", 2, "--json"
    )
    assert strict_json(text)["interrupted"] is True


def test_nobody_is_shown_a_bar_who_does_not_watch(box, capsys):
    assert cli.main(["simulate", *map(str, box), "--drops", "30000", "--json"]) == 0
    assert "\r" not in capsys.readouterr().err
