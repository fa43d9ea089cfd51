"""Parts and findings that the tests of the report share."""

from __future__ import annotations

from functools import cache

from ros_pose_stats import part_from_mesh
from ros_pose_stats.report import Feeder, investigate
from ros_pose_stats.shapes.closed_forms import box
from ros_pose_stats.shapes.demo_parts import DEMO_PARTS


@cache
def block(wanted=(), rate=None, kick=None):
    """Findings on a box of 40 x 30 x 20 mm after 300 drops."""
    part = part_from_mesh(*box(0.04, 0.03, 0.02), part_id="block")
    return investigate(part, drops=300, seed=1, workers=1, feeder=Feeder(wanted, rate, kick))


@cache
def demo(name):
    """Findings on a demo part after 200 drops."""
    part = part_from_mesh(*DEMO_PARTS[name](), part_id=name, unit="mm")
    return investigate(part, drops=200, seed=1, workers=1)
