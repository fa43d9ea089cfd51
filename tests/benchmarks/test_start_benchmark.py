"""Reading an import trace."""

from __future__ import annotations

from benchmarks.start import by_package

TRACE = """\
import time: self [us] | cumulative | imported package
import time:       120 |        120 |   numpy.linalg
import time:        30 |        150 | numpy
a line of something else
import time:         7 |        157 | ros_pose_stats.cli
"""


def test_modules_are_summed_by_package():
    assert by_package(TRACE) == {"numpy": 150, "ros_pose_stats": 7}
