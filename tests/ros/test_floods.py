"""What comes too often is said when it begins, and then once a minute."""

from __future__ import annotations

import pytest

from ros_pose_stats.ros import floods
from ros_pose_stats.ros.floods import MINUTE, MOST_SOURCES, Floods


@pytest.fixture
def now(monkeypatch):
    """The clock, in a list."""
    clock = [50.0]
    monkeypatch.setattr(floods.time, "monotonic", lambda: clock[0])
    return clock


@pytest.fixture
def said():
    return []


@pytest.fixture
def watch(now, said):
    return Floods(said.append)


def test_what_is_usual_is_not_said(watch, now, said):
    for _ in range(5):
        assert all(watch.count("meshes", 10) for _ in range(10))
        now[0] += MINUTE
    assert said == [] and watch.current() == {}


def test_a_flood_is_said_when_it_begins_and_once_a_minute(watch, now, said):
    for count in (25, 30):
        within = [watch.count("meshes", 10) for _ in range(count)]
        assert within == 10 * [True] + (count - 10) * [False]
        assert watch.current() == {"meshes": count}
        now[0] += MINUTE
    assert said == ["a flood: more than 10 of meshes within a minute",
                    "a flood: 25 of meshes in the last minute"]
    assert watch.current() == {"meshes": 30}
    assert said[2:] == ["a flood: 30 of meshes in the last minute"]
    now[0] += MINUTE
    assert watch.current() == {} and len(said) == 3


def test_a_flood_of_sources_is_bounded(watch, said):
    for number in range(3 * MOST_SOURCES):
        watch.count(f"part {number}", 0)
    assert len(watch.current()) == MOST_SOURCES == len(said)
