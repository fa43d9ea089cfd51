"""Which warnings are serious, and that the page about them says the same."""

import re

from ros_pose_stats.records.warnings import SERIOUS, is_serious, serious_first
from tests.running import ROOT


def test_serious_ones_come_first_and_else_in_their_order():
    told = ["ROUNDED: a: b.", "CONFLICT: c.", "CLUSTERED: UNIT_SUSPECT.", "UNIT_SUSPECT: d."]
    assert [is_serious(one) for one in told] == [False, True, False, True]
    assert serious_first(told) == [told[1], told[3], told[0], told[2]]


def test_the_document_marks_the_same_ones():
    text = (ROOT / "docs/warnings.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([A-Z_]+)` \|([^|]*)\|", text, re.MULTILINE)
    assert {code for code, mark in rows if mark.strip() == "yes"} == SERIOUS
    assert {mark.strip() for _, mark in rows} == {"yes", ""}
