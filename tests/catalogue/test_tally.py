"""What the rows of a catalogue come to."""

from ros_pose_stats.catalogue.tally import tally

UNIT, OPEN, ROUND = "UNIT_SUSPECT: 80 m.", "OPEN_MESH: a hole.", "ROUNDED: two edges."


def row(share, *warnings):
    return {"file": "part", "refusal": "", "best_share": share, "warnings": list(warnings)}


def test_each_part_counts_once_and_refused_ones_are_named():
    found = tally([row(0.9, OPEN, UNIT, UNIT, ROUND), row(0.8999, UNIT), row(1.0, ROUND),
                   row(None), {"file": "none", "refusal": "no part"}])
    assert (found.answered, found.one_way, found.doubted) == (4, 2, 2)
    assert found.codes == "UNIT_SUSPECT 2, OPEN_MESH 1"
    assert found.refused == {"none": "no part"}


def test_nothing():
    found = tally([])
    assert (found.answered, found.doubted, found.codes, found.refused) == (0, 0, "", {})
