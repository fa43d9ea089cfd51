"""A node that is started again with nothing new: the same parts, and hardly a byte more."""

from __future__ import annotations

import shutil
from itertools import count

import pytest
from ros_pose_stats_msgs.msg import JobEvent

from ros_pose_stats.recording.run_names import runs

from ..harness.bags import recorded, size_of
from ..harness.cell import cell_of, latched
from ..harness.client import until
from ..harness.jobs import LONG, start
from ..harness.parts import WEDGE, fine_box, flat

TRIANGLES = 40_000
"""Of a part of about 1 MB."""


@pytest.fixture
def again(domain, tmp_path):
    """Starts one node after the other on the same folder."""
    return lambda **values: cell_of(domain, tmp_path, "small", **values)


def names(client):
    return {one.part_id for one in client.call("get_statistics").statistics}


def estimate(client, *part_ids):
    for number, part_id in enumerate(part_ids):
        client.good("estimate", part=flat(((1.0 + 0.1 * number) * WEDGE[0], WEDGE[1]), part_id))


def test_nothing_new_adds_nothing(again, tmp_path):
    vertices, triangles = fine_box(TRIANGLES)
    with again() as (_, client):
        client.good("estimate", part=flat((vertices, triangles), "large"))
        before = latched(client, "large")
    full = size_of(tmp_path)
    for _ in range(2):
        with again() as (_, client):
            assert latched(client, "large") == before
        assert size_of(tmp_path) - full < 0.01 * (vertices.nbytes + triangles.nbytes)
    with again() as (_, client):
        estimate(client, "small")
    with again() as (_, client):
        until(lambda: names(client) == {"large", "small"}, "both parts")
        assert latched(client, "large") == before
    assert size_of(tmp_path) - full < 0.2 * full
    assert [one.part_id for one in recorded(tmp_path, "part_mesh")] == ["large", "small"]


def test_at_most_max_parts_the_last_used(again):
    with again() as (_, client):
        estimate(client, *"abcd")
        client.good("estimate", part_id="a")
    with again(max_parts=2) as (_, client):
        assert names(client) == {"d", "a"}
        estimate(client, "new")
    with again() as (_, client):
        assert names(client) == {"a", "new"}


def test_what_was_pushed_out_stays_away(again, tmp_path):
    with again(max_parts=2) as (node, client):
        estimate(client, *"abc")
        node.kill()
    with again() as (_, client):
        assert names(client) == {"b", "c"}
    assert [event.part_id for event in recorded(tmp_path, "job_events")
            if event.event == JobEvent.PART_FORGOTTEN] == ["a"]


def test_copies_and_renamed_runs_change_nothing(again, tmp_path):
    with again() as (node, client):
        estimate(client, "kept", "forgotten")
        job_id = start(client, "kept", LONG)
        node.kill()
    (first,) = runs(tmp_path)
    shutil.copytree(first, tmp_path / (first.name + "0"))  # mended nowhere: its files fit not
    for _ in range(3):
        with again() as (_, client):
            if "forgotten" in names(client):
                client.good("forget_part", part_id="forgotten")
                shutil.move(first, tmp_path / "monday")
            assert names(client) == {"kept"}
            estimate(client, "other")
            client.good("forget_part", part_id="other")
    ends = [event.job_id for event in recorded(tmp_path, "job_events")
            if event.event == JobEvent.CANCELLED]
    assert ends == [job_id]


def test_a_mesh_that_is_gone_is_said_once(again, tmp_path):
    with again() as (_, client):
        estimate(client, "part")
    with again() as (_, client):
        estimate(client, "other")
    shutil.rmtree(runs(tmp_path)[0])
    with again() as (node, client):
        assert names(client) == {"other"}
        said = [line for line in node.lines if "restored part" in line]
        assert len(said) == 1 and "part 'part'" in said[0]
    with again() as (node, client):
        assert names(client) == {"other"} and "restored part" not in node.log


def test_a_run_with_live_meshes_makes_room_once_they_are_recorded_again(again, tmp_path):
    vertices, triangles = fine_box(TRIANGLES // 10)
    with again() as (_, client):
        client.good("estimate", part=flat((vertices, triangles), "large"))
        before = latched(client, "large")
    (first,) = runs(tmp_path)
    bound = 8 * size_of(tmp_path)
    with again(max_log_bytes=bound) as (node, client):
        sizes = count(1)

        def gone():
            client.good("estimate", part=flat(
                ((1.0 + 0.01 * next(sizes)) * vertices, triangles), "another"))
            return not first.is_dir()

        until(gone, "the first run to be deleted")
        node.kill()
        assert size_of(tmp_path) < 1.25 * bound
    with again() as (_, client):
        assert names(client) == {"large", "another"}
        assert latched(client, "large").part_digest == before.part_digest
