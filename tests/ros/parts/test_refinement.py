"""Background drops after each new mesh."""

from __future__ import annotations

from itertools import pairwise

import pytest

from ..harness.client import QUEUED, RUNNING, until
from ..harness.jobs import LONG, cancel_all, finished, get, known_part, reached, start
from ..harness.parts import WEDGE, flat, new_id


@pytest.fixture(scope="module")
def client(domain, tmp_path_factory):
    """A client of a node whose parameters these tests change."""
    from ..harness.client import Client
    from ..harness.node import NodeProcess

    with NodeProcess(tmp_path_factory.mktemp("bags"), "-r", "__ns:=/refining") as node:
        node.ready()
        with Client(domain, "/refining/pose_stats") as found:
            yield found


@pytest.fixture(autouse=True)
def back_to_default(client):
    yield
    client.set(refine_drops=0, target_error=0.0)
    cancel_all(client)


def jobs_of(client, part_id):
    listed = client.call("list_drop_simulations")
    return [job_id for job_id, part in zip(listed.job_id, listed.part_id, strict=True)
            if part == part_id]


@pytest.mark.long
def test_off_by_default(client):
    assert jobs_of(client, known_part(client)) == []


@pytest.mark.long
def test_refine_drops_sharpens_what_is_latched(client):
    client.set(refine_drops=40_000)
    with client.late_joiner() as joiner:
        part_id = known_part(client)
        final = joiner.wait(part_id, lambda message: message.drops and message.final)
        told = joiner.of(part_id)
    assert (final.drops, final.method) == (40_000, "hybrid")
    assert (told[0].method, told[0].final) == ("split", True)
    assert not any(message.final for message in told[1:-1])
    assert all(b.revision > a.revision for a, b in pairwise(told))
    assert all(b.drops > a.drops for a, b in pairwise(told))


def test_target_error_is_reached(client):
    client.set(target_error=0.01)
    with client.late_joiner() as joiner:
        part_id = known_part(client)
        final = joiner.wait(part_id, lambda message: message.drops and message.final)
    assert 0.0 < final.expected_error <= 0.01
    assert final.drops < 10_000


def test_a_clients_job_is_served_first_and_the_refinement_then_completes(client):
    client.set(refine_drops=40_000)
    with client.late_joiner() as joiner:
        part_id = known_part(client)
        (refinement,) = until(lambda: jobs_of(client, part_id))
        reached(client, refinement, RUNNING)
        finished(client, start(client, part_id, 300, seed=1))
        assert get(client, refinement).state in (QUEUED, RUNNING)
        assert finished(client, refinement).statistics.drops == 40_000
        joiner.wait(part_id, lambda message: message.drops == 40_000 and message.final)


def test_a_change_of_the_parameter_refines_known_parts(client):
    part_id = known_part(client)
    client.set(refine_drops=2000)
    with client.late_joiner() as joiner:
        final = joiner.wait(part_id, lambda message: message.drops and message.final)
    assert final.drops == 2000


def test_a_copy_of_the_mesh_is_not_refined_again(client):
    client.set(refine_drops=2000)
    part_id = known_part(client)
    (job_id,) = until(lambda: jobs_of(client, part_id))
    finished(client, job_id)
    client.good("estimate", part=flat(WEDGE, part_id))
    assert jobs_of(client, part_id) == [job_id]


def test_a_new_mesh_ends_the_refinement_of_the_old(client):
    client.set(refine_drops=LONG)
    part_id = new_id()
    client.good("estimate", part=flat(WEDGE, part_id))
    (old,) = until(lambda: jobs_of(client, part_id))
    vertices, triangles = WEDGE
    client.good("estimate", part=flat((2.0 * vertices, triangles), part_id))
    until(lambda: len(jobs_of(client, part_id)) == 2)
    until(lambda: get(client, old).state not in (QUEUED, RUNNING))


def test_forgetting_the_part_ends_its_refinement(client):
    client.set(refine_drops=LONG)
    part_id = known_part(client)
    (job_id,) = until(lambda: jobs_of(client, part_id))
    client.good("forget_part", part_id=part_id)
    until(lambda: get(client, job_id).state not in (QUEUED, RUNNING))
    with client.late_joiner() as joiner:
        joiner.wait(known_part(client))
        assert part_id not in joiner.parts()


def test_switching_it_off_ends_it(client):
    client.set(refine_drops=LONG)
    part_id = known_part(client)
    (job_id,) = until(lambda: jobs_of(client, part_id))
    client.set(refine_drops=0)
    until(lambda: get(client, job_id).state not in (QUEUED, RUNNING))
