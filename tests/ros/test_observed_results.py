"""What the node learns from a camera's counts: results, restarts, changes of the cell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ros_pose_stats_msgs.msg import PoseCounts

from ros_pose_stats import shapes
from ros_pose_stats.plates import PlateProfile
from ros_pose_stats.plates.profile import write_profile
from ros_pose_stats.recording.analysis.numbering import Numbering
from ros_pose_stats.ros.parts.cell_counts import RECENT, CellCounts, Ground, count_health

from .harness.cell import Health, MeshPublisher, cell_of, latched
from .harness.client import until
from .harness.parts import WEDGE, counts, flat, probabilities

NODE = {"plate": "glass"}


@pytest.fixture
def seeing(domain, tmp_path):
    with cell_of(domain, tmp_path, "learning", **NODE) as (node, client):
        model = client.good("estimate", part=flat(WEDGE, "wedge")).statistics
        yield node, client, model
        node.assert_sound()


def counted(model, numbers, **fields):
    index = [pose.index for pose in model.poses][:len(numbers)]
    return PoseCounts(**{
        "part_id": model.part_id, "part_digest": model.part_digest, "plate": "glass",
        "cluster_tolerance": model.cluster_tolerance, "round_sides": model.round_sides,
        "index": index, "count": numbers, **fields})


def camera_of(client):
    return MeshPublisher(client, f"{client.prefix}/pose_counts", PoseCounts).matched()


def learnt(client, observed):
    """What is latched, once it has learnt from so many parts."""
    def found():
        result = latched(client, "wedge")
        return result if result.observed == observed else None
    return until(found, f"a result of {observed} parts")


def test_counts_sharpen_what_is_latched(seeing):
    _, client, model = seeing
    camera, before = camera_of(client), latched(client, "wedge")
    camera.publish(counted(model, [3, 7]))
    first = learnt(client, 10)
    assert (first.method, first.drops, first.final) == ("observed", 0, True)
    assert first.revision > before.revision
    for _ in range(30):
        camera.publish(counted(model, [3, 7]))
    later = learnt(client, 310)
    assert later.plate_error == later.expected_error < 0.6 * first.expected_error
    one, other = (pose.index for pose in model.poses[:2])
    assert counts(later.poses)[one] == 93 and counts(later.poses)[other] == 217
    assert probabilities(later.poses)[other] > probabilities(first.poses)[other]
    assert probabilities(later.poses)[other] == pytest.approx(0.7, abs=0.05)
    fed = client.good("feeding", part_id="wedge", wanted=[one], rate=60.0)
    assert fed.message == "From 310 parts seen (observed)."
    assert "310 parts counted of 1 kinds" in Health(client).line("counts")[0].message


def test_counts_go_on_where_the_plate_brings_its_round_sides(domain, tmp_path):
    """The file is fitted anew elsewhere, and the plate is set again."""
    file = tmp_path / "plates.yaml"
    glass = PlateProfile("glass", 0.4, 0.3, 0.5, 0.2, 0.1, 0.3, 0.03, 0.5, ("wedge",), 900,
                         "2026-11-23T12:00:00+00:00", "1")
    write_profile(file, glass)
    with cell_of(domain, tmp_path / "bags", "rolling", plates=str(file), **NODE) as (node, client):
        drum = flat(shapes.prism(64, 0.01, 0.02), "wedge")
        model = client.good("estimate", part=drum).statistics
        camera_of(client).publish(counted(model, [30, 20]))
        before = learnt(client, 50)
        write_profile(file, replace(glass, round_sides=96, round_sides_low=48,
                                    round_sides_high=96))
        assert client.set(plate="glass") == {}
        after = until(lambda: known_sides(client, 96), "the plate's round_sides")
        assert (before.round_sides, after.observed, after.method) == (192, 50, "observed")
        assert counts(after.poses) == counts(before.poses)
        node.assert_sound()


def known_sides(client, sides):
    found = latched(client, "wedge")
    return found if found.round_sides == sides else None


def test_others_are_recorded_only(seeing):
    """Of another plate, another numbering, another part, or more than there can be."""
    _, client, model = seeing
    camera = camera_of(client)
    for fields in ({"plate": "steel"}, {"cluster_tolerance": 0.01}, {"part_digest": "ab" * 32},
                   {"count": [2**63, 2**63]}, {"index": [0, 99]}):
        camera.publish(counted(model, [50, 50], **fields))
    camera.publish(counted(model, [1, 2], plate=""))
    learnt(client, 3)


def test_a_cell_that_contradicts_the_model(seeing):
    _, client, model = seeing
    camera_of(client).publish(counted(model, [0, 0, 400]))
    found = learnt(client, 400)
    assert any(line.startswith("CONFLICT:") for line in found.warnings)
    assert found.poses[0].index == model.poses[2].index


def test_what_was_learnt_is_there_after_a_restart_and_not_on_another_plate(domain, tmp_path):
    with cell_of(domain, tmp_path, "again", **NODE) as (_, client):
        model = client.good("estimate", part=flat(WEDGE, "wedge")).statistics
        camera_of(client).publish(counted(model, [30, 70]))
        before = learnt(client, 100)
    with cell_of(domain, tmp_path, "again", **NODE) as (_, client):
        again = learnt(client, 100)
        assert counts(again.poses) == counts(before.poses)
        assert probabilities(again.poses) == pytest.approx(probabilities(before.poses))
        camera_of(client).publish(counted(model, [1, 0]))
        learnt(client, 101)
        assert client.set(restitution=0.2) == {}
        until(lambda: latched(client, "wedge").restitution == 0.2)
        assert latched(client, "wedge").observed == 101  # of the plate, not of the model
        assert client.set(plate="steel") == {}
        assert learnt(client, 0).method != "observed"


class TestDrift:
    def cell(self):
        return CellCounts(Ground(Numbering(0.0025, 192), "glass"), np.zeros(3, np.int64))

    def seen(self, cell, shares, parts, seed=0):
        drawn = np.random.default_rng(seed).choice(3, parts, p=shares)
        for index in drawn.tolist():
            cell.add(PoseCounts(index=[index], count=[1]))
        return cell

    def test_none_of_one_and_the_same_cell(self):
        """Looked at after every hundred of 20 000 parts, at one in 10 000 by chance a look."""
        cell = self.cell()
        for block in range(200):
            self.seen(cell, [0.5, 0.3, 0.2], 100, seed=block)
            assert cell.drift() == ""
        assert not count_health({"part": cell, "other": None}).warn

    def test_a_change(self):
        cell = self.seen(self.seen(self.cell(), [0.5, 0.3, 0.2], 1000), [0.3, 0.5, 0.2], RECENT, 1)
        assert f"the last {RECENT} parts" in cell.drift()
        line = count_health({"part": cell})
        assert line.warn and "changed 'part'" in line.text

    def test_messages_without_parts_are_not_kept(self):
        cell = self.cell()
        for _ in range(5):
            cell.add(PoseCounts(index=[0], count=[0]))
        assert not cell._recent
