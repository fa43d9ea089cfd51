"""Tests and seconds by room, from a report of pytest.

`pytest --junitxml=FILE ...`, then `python -m tests.house.durations FILE`.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from xml.etree import ElementTree


def room_of(module: str) -> str:
    """`tests.mesh.test_parts.TestHulls` is of the room geometry."""
    _, room, *_ = module.split(".")
    return "(top)" if room.startswith("test_") else room


def print_durations(report: str) -> None:
    """A line a room, the longest first, and the sum."""
    seconds = defaultdict(list)
    for case in ElementTree.parse(report).iter("testcase"):
        taken = float(case.get("time"))
        seconds["all"].append(taken)
        seconds[room_of(case.get("classname"))].append(taken)
    print(f"{'room':16}{'tests':>7}{'seconds':>9}{'longest':>9}")
    for room, taken in sorted(seconds.items(), key=lambda item: -sum(item[1])):
        print(f"{room:16}{len(taken):7}{sum(taken):9.1f}{max(taken):9.1f}")


if __name__ == "__main__":
    print_durations(sys.argv[1])
