"""The method `auto`: an estimate at once, and drops behind it where a target asks for them."""

from __future__ import annotations

import re

import numpy as np
import pytest

from ros_pose_stats import estimate
from ros_pose_stats.planning.confidence import estimate_bound, pose_prior
from ros_pose_stats.records import DropScene
from ros_pose_stats.resting.poses import resting_poses

from ..harness.client import CANCELLED, until
from ..harness.jobs import LONG, cancel_all, cancelled, finished, get, known_part, start
from ..harness.parts import WEDGE, flat, library_part, new_id, whole

TARGET = 0.01
"""Below what any estimate of the wedge keeps."""

MOST = 10_000


@pytest.fixture(scope="module")
def client(domain, tmp_path_factory):
    """A client of a node whose parameters these tests change."""
    from ..harness.client import Client
    from ..harness.node import NodeProcess

    with NodeProcess(tmp_path_factory.mktemp("bags"), "-r", "__ns:=/auto") as node:
        node.ready()
        with Client(domain, "/auto/pose_stats") as found:
            yield found


@pytest.fixture(autouse=True)
def back_to_default(client):
    yield
    client.set(refine_drops=0, target_error=0.0, drops=MOST, default_method="auto",
               max_queued_jobs=16)
    cancel_all(client)


def jobs_of(client, part_id):
    listed = client.call("list_drop_simulations")
    return [job_id for job_id, part in zip(listed.job_id, listed.part_id, strict=True)
            if part == part_id]


def latched(client, part_id):
    return client.good("get_statistics", part_id=part_id).statistics[0]


def job_named(message):
    """The job that an answer says will refine it."""
    return re.search(r"job (\S+)\.$", message)[1]


def bound_of(found):
    """What drops and estimate together keep with 90 % confidence, by the library."""
    prior = pose_prior(resting_poses(library_part(WEDGE)), DropScene())
    counts = np.array([pose.count for pose in sorted(found.poses, key=lambda one: one.index)])
    return prior.updated(counts).error_quantile()


class TestAnEstimate:
    @pytest.mark.parametrize("method", ["", "auto"])
    def test_is_the_most_accurate_one(self, client, method):
        answer = client.good("estimate", part=flat(WEDGE, new_id()), method=method)
        assert answer.statistics.method == "split"
        assert "split" in answer.message and "most accurate" in answer.message

    def test_that_is_good_enough_needs_no_drops(self, client):
        part_id = known_part(client)
        answer = client.good("estimate", part_id=part_id, target_error=0.2)
        assert (answer.statistics.method, answer.statistics.drops) == ("split", 0)
        assert "90 % confidence" in answer.message and "20 points" in answer.message
        assert not any("TARGET_MISSED" in line for line in answer.statistics.warnings)
        assert jobs_of(client, part_id) == []

    def test_good_enough_is_judged_by_the_bound(self, client):
        best = estimate(library_part(WEDGE))
        prior = pose_prior(resting_poses(library_part(WEDGE)), DropScene())
        between = 0.5 * (best.expected_error + estimate_bound(prior))
        part_id = known_part(client)
        answer = client.good("estimate", part_id=part_id, target_error=between)
        ended = finished(client, job_named(answer.message)).statistics
        assert bound_of(ended) <= between
        shown = latched(client, part_id)  # for it is better than the estimate in any case
        assert (shown.method, shown.job_id) == ("hybrid", ended.job_id)
        assert shown.expected_error < best.expected_error

    def test_by_name_is_never_refined(self, client):
        part_id = known_part(client)
        found = client.good("estimate", part_id=part_id, method="csae", target_error=TARGET)
        assert any("method auto" in line for line in found.statistics.warnings)
        assert found.statistics.method == "csae" and jobs_of(client, part_id) == []

    def test_of_a_node_with_another_default_is_refined_where_auto_is_asked_for(self, client):
        client.set(default_method="area")
        part_id = known_part(client)
        assert client.good("estimate", part_id=part_id).statistics.method == "area"
        answer = client.good("estimate", part_id=part_id, method="auto", target_error=TARGET)
        assert answer.statistics.method == "split"
        assert finished(client, job_named(answer.message)).statistics.method == "hybrid"


class TestATargetThatIsMissed:
    def test_is_said_at_once_and_reached_in_the_background(self, client):
        with client.late_joiner() as joiner:
            part_id = known_part(client)
            answer = client.good("estimate", part_id=part_id, target_error=TARGET)
            first = answer.statistics
            final = joiner.wait(part_id, lambda message: message.drops and message.final)
        assert (first.method, first.drops) == ("split", 0)
        assert any(line.startswith("TARGET_MISSED") for line in first.warnings)
        assert "split alone is within" in answer.message and "1 points" in answer.message
        assert (final.method, final.job_id) == ("hybrid", job_named(answer.message))
        assert final.expected_error < TARGET < first.expected_error
        assert bound_of(final) <= TARGET
        assert 0 < final.drops < MOST
        assert finished(client, final.job_id).statistics.poses == final.poses

    def test_drops_already_made_answer_the_next_time(self, client):
        part_id = known_part(client)
        asked = {"part_id": part_id, "target_error": TARGET}
        finished(client, job_named(client.good("estimate", **asked).message))
        again = client.good("estimate", **asked)
        assert whole(again.statistics) == whole(latched(client, part_id))
        assert "drops already made" in again.message
        assert len(jobs_of(client, part_id)) == 1

    def test_the_same_again_is_the_same_job(self, client):
        start(client, known_part(client), LONG)  # which keeps the queue busy
        part_id = known_part(client)
        answers = [client.good("estimate", part_id=part_id, target_error=TARGET).message
                   for _ in range(3)]
        assert len(set(map(job_named, answers))) == 1
        other = client.good("estimate", part_id=part_id, target_error=0.005).message
        assert job_named(other) != job_named(answers[0])

    def test_a_full_queue_is_told_beside_the_estimate(self, client):
        client.set(max_queued_jobs=0)
        busy = start(client, known_part(client), LONG)
        part_id = known_part(client)
        answer = client.good("estimate", part_id=part_id, target_error=TARGET)
        assert "max_queued_jobs" in answer.message and answer.statistics.method == "split"
        assert jobs_of(client, part_id) == []
        cancelled(client, busy)

    def test_drops_are_bounded_and_not_tried_again(self, client):
        client.set(drops=200)
        part_id = known_part(client)
        asked = {"part_id": part_id, "target_error": 0.001}
        ended = finished(client, job_named(client.good("estimate", **asked).message))
        assert ended.statistics.drops == 200 and "TARGET_MISSED" in ended.message
        again = client.good("estimate", **asked)
        assert again.statistics.drops == 200 and "parameter drops" in again.message
        assert len(jobs_of(client, part_id)) == 1

    def test_in_another_scene_is_not_latched(self, client):
        part_id = known_part(client)
        asked = {"part_id": part_id, "target_error": TARGET, "restitution": 0.2}
        job_id = job_named(client.good("estimate", **asked).message)
        ended = finished(client, job_id).statistics
        assert (ended.method, ended.restitution) == ("hybrid", 0.2)
        assert latched(client, part_id).method == "split"
        again = client.good("estimate", **asked)
        assert (again.statistics.method, again.statistics.job_id) == ("hybrid", job_id)

    def test_the_job_can_be_cancelled(self, client):
        client.set(drops=LONG)
        part_id = known_part(client)
        job_id = job_named(client.good("estimate", part_id=part_id, target_error=1e-5).message)
        until(lambda: get(client, job_id).drops_done > 5000)
        assert client.good("estimate", part_id=part_id).statistics.method == "split"
        ended = cancelled(client, job_id)
        assert ended.state == CANCELLED and ended.statistics.method == "hybrid"
        shown = latched(client, part_id)
        assert (shown.method, shown.drops, shown.final) == (
            "hybrid", ended.statistics.drops, True)


class TestTheNodesOwnTarget:
    def test_is_kept_with_confidence(self, client):
        client.set(target_error=TARGET)
        with client.late_joiner() as joiner:
            part_id = known_part(client)
            final = joiner.wait(part_id, lambda message: message.drops and message.final)
        assert final.method == "hybrid" and bound_of(final) <= TARGET

    def test_that_an_estimate_keeps_needs_no_drops(self, client):
        client.set(target_error=0.2)
        assert jobs_of(client, known_part(client)) == []

    def test_with_a_named_method_is_reached_by_plain_drops(self, client):
        client.set(default_method="combined", target_error=TARGET)
        with client.late_joiner() as joiner:
            part_id = known_part(client)
            final = joiner.wait(part_id, lambda message: message.drops and message.final)
        assert final.method == "simulation" and final.expected_error <= TARGET


def test_drops_that_are_asked_for_stay_plain(client):
    part_id = known_part(client)
    found = finished(client, start(client, part_id, 500)).statistics
    assert found.method == "simulation"
    assert [pose.probability for pose in found.poses] == [
        pose.count / found.drops for pose in found.poses]
