"""How long a refusal is news, whatever the clock on the wall does."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from ros_pose_stats.ros import diagnostics
from ros_pose_stats.ros.diagnostics import COPY_SECONDS, RECENT_SECONDS, Refusals

HOUR = 3600.0


class Clocks:
    """One that only goes on, and one that somebody sets."""

    def __init__(self):
        self.monotonic_seconds, self.wall_seconds = 1000.0, 1e9

    def go_on(self, seconds, wall=None):
        self.monotonic_seconds += seconds
        self.wall_seconds += seconds if wall is None else wall


@pytest.fixture
def clocks(monkeypatch):
    found = Clocks()
    monkeypatch.setattr(diagnostics, "now", lambda: int(1e9 * found.wall_seconds))
    monkeypatch.setattr(diagnostics, "time", SimpleNamespace(
        monotonic=lambda: found.monotonic_seconds))
    return found


@pytest.mark.parametrize("jump", [0.0, -HOUR, HOUR])
def test_a_refusal_is_a_warning_for_a_minute(clocks, jump):
    refusals = Refusals(print)
    refusals.refuse("topic", "reason")
    clocks.go_on(1.0, jump)
    warn, text, _ = refusals.health(0, 0)
    assert (warn, text) == (True, "refused: topic: reason")
    clocks.go_on(RECENT_SECONDS)
    assert not refusals.health(0, 0).warn


@pytest.mark.parametrize("jump", [0.0, -HOUR, HOUR])
def test_copies_are_told_from_what_comes_again(clocks, jump):
    said = []
    refusals = Refusals(said.append)
    refusals.refuse("topic", "reason")
    clocks.go_on(0.5 * COPY_SECONDS, jump)
    refusals.refuse("topic", "reason")
    assert said == ["topic: mesh refused: reason"]
    refusals.refuse("topic", "another", "count")
    clocks.go_on(COPY_SECONDS)
    refusals.refuse("topic", "reason")
    assert said[1:] == ["topic: count refused: another", "topic: mesh refused: reason"]
    assert refusals.refused == 3
