"""Bags of the last run whose messages are damaged or hostile: the rest is gone on with."""

from __future__ import annotations

from functools import partial
from itertools import islice
from random import Random

import pytest
from numpy.testing import assert_array_equal
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent, PartMesh, PoseStatistics, StablePose

from ros_pose_stats.recording.run_names import runs
from ros_pose_stats.version import VERSION
from tests.fuzz.messages.message_seeds import HOSTILE_COUNTS, HOSTILE_NAMES, HOSTILE_NUMBERS
from tests.fuzz.messages.messages import fuzzed, mutated
from tests.volume import few_quick

from ..harness.cell import cell_of, latched
from ..harness.client import CANCELLED
from ..harness.jobs import finished, start
from ..harness.parts import WEDGE, flat, library_part
from ..harness.readers import on_topic, raw
from .test_last_run import RUNS, Writing, factors, found, vertices

VERTICES, TRIANGLES = WEDGE
HEAD = 120
"""Bytes of a result in which part and digest are, but not all of the rest."""


def result(part_id="part", factor=1.0, **fields):
    """As the node would have recorded it for a mesh of this size."""
    digest = library_part((factor * VERTICES, TRIANGLES), part_id).digest
    return PoseStatistics(part_id=part_id, part_digest=digest, **fields)


def event(kind=JobEvent.QUEUED, job_id="job", **fields):
    return JobEvent(event=kind, job_id=job_id, **{"restitution": 0.5, **fields})


def bytes_of(message):
    return bytes(serialize_message(message))


def write(writing, topic, data):
    writing.log.write(f"/pose_stats/{topic}", data, durable=False)


BAD = {
    "no mesh": ("part_mesh", bytes_of(JobEvent())),
    "a mesh in no form": ("part_mesh", bytes_of(PartMesh(part_id="x"))),
    "half a result": ("pose_statistics", bytes_of(result())[:HEAD]),
    "a result that cannot be numbered on": (
        "pose_statistics", bytes_of(result(revision=2**64 - 1))),
    "a pose that cannot be drawn": ("pose_statistics", bytes_of(result(
        poses=[StablePose(index=2**32 - 1)]))),
    "no result at all": ("pose_statistics", b"\0\1\0\0\xff\xff"),
    "half an event": ("job_events", bytes_of(event())[:30]),
    "a job without a scene": ("job_events", bytes_of(event(restitution=float("nan")))),
    "a job at an endless height": ("job_events", bytes_of(event(drop_height=float("inf")))),
}


class TestMessages:
    @pytest.mark.parametrize("kind", BAD)
    def test_a_bad_one_costs_itself_only(self, tmp_path, kind):
        writing = Writing(tmp_path, 0)
        writing.mesh("part", 1.0)
        write(writing, *BAD[kind])
        writing.part("after", 3.0)
        writing.event(JobEvent.PART_FORGOTTEN, part_id="nobody")
        writing.end()
        run = found(tmp_path)
        assert factors(tmp_path, run) == {"part": 1.0, "after": 3.0}
        assert run.results["after"].part_digest == "digest 3.0"
        assert "part" not in run.results and run.unfinished == {}
        assert [bag.name for bag in run.problems] == [RUNS[0]]
        assert all(problem.isprintable() for problem in run.problems.values())

    def test_earlier_meshes_are_found_behind_a_bag_with_bad_ones(self, tmp_path):
        """A part keeps its own mesh, whatever is wrong before it."""
        writing = Writing(tmp_path, 0)
        writing.part("old", 1.0)
        write(writing, *BAD["no mesh"])
        writing.part("older", 1.5)
        writing.end()
        writing = Writing(tmp_path, 1)
        writing.part("part", 2.0)
        writing.part("other", 3.0)
        writing.part("part", 4.0)
        writing.result("part", 2.0, 9)
        writing.die()
        run = found(tmp_path)
        assert factors(tmp_path, run) == {"old": 1.0, "older": 1.5, "part": 2.0, "other": 3.0}
        assert run.results["part"].revision == 9

    def test_jobs_of_the_same_bag_are_still_known(self, tmp_path):
        writing = Writing(tmp_path, 0)
        write(writing, "job_events", bytes_of(event(job_id="good")))
        write(writing, *BAD["a job without a scene"])
        writing.end()
        assert list(found(tmp_path).unfinished) == ["good"]


def hostile(chance):
    """Results and events with odd values, some of their bytes changed."""
    number, count = partial(chance.choice, HOSTILE_NUMBERS), partial(chance.choice, HOSTILE_COUNTS)
    name = partial(chance.choice, HOSTILE_NAMES)
    statistics = bytes_of(result(
        name().replace("\0", ""), revision=count(), drops=count(), seed=count(), radius=number(),
        restitution=number(), expected_error=number(), version=VERSION, job_id="x",
        poses=[StablePose(index=count() % 2**32, probability=number())]))
    job = bytes_of(event(chance.randrange(8), name().replace("\0", ""), drops=count(),
                         restitution=chance.choice((0.5, number())), drop_height=number(),
                         cluster_tolerance=chance.choice((0.005, number()))))
    for topic, data, other in (("pose_statistics", statistics, job),
                               ("job_events", job, statistics)):
        yield topic, mutated(chance, data, other) if chance.random() < 0.5 else data


def write_hostile(writing, seed, rounds):
    chance = Random(seed)
    for data in islice(fuzzed(PartMesh, seed, rounds), rounds):
        write(writing, "part_mesh", data)
        for topic, other in hostile(chance):
            write(writing, topic, other)


@pytest.mark.parametrize("seed", few_quick(range(4), 1))
def test_hundreds_of_bad_ones(tmp_path, seed):
    writing = Writing(tmp_path, 0)
    writing.part("good", 1.0)
    write_hostile(writing, seed, 150)
    writing.part("last", 2.0)
    writing.end()
    run = found(tmp_path)
    for part_id, factor in (("good", 1.0), ("last", 2.0)):
        assert_array_equal(vertices(tmp_path, run, part_id), factor * VERTICES)
    assert len(run.problems) == 1


@pytest.mark.long
@pytest.mark.parametrize("end", few_quick(["die", "end"], 1))
def test_a_node_starts_says_so_and_serves(domain, tmp_path, end):
    """And mends what is unfinished, so that the next one has nothing to say."""
    writing = Writing(tmp_path, 0, "damaged/pose_stats")
    writing.mesh("good", 1.0)
    for topic, data in BAD.values():
        write(writing, topic, data)
    write_hostile(writing, 7, 100)
    write(writing, "part_mesh", bytes_of(flat(WEDGE, "..")))
    write(writing, "job_events", bytes_of(event(job_id="left\nFATAL", part_id="\x1b[31m")))
    getattr(writing, end)()
    digest = library_part(WEDGE).digest
    with cell_of(domain, tmp_path, "damaged") as (node, client):
        assert f"not all of {RUNS[0]} could be read" in node.log
        assert "\x1b[31m" not in node.log and "'left\\nFATAL': CANCELLED" in node.log
        assert latched(client, "good").part_digest == latched(client, "..").part_digest == digest
        listed = client.call("list_drop_simulations")
        assert set(listed.state) == {CANCELLED}
        job_id = start(client, "good", 100)
        assert finished(client, job_id).statistics.drops == 100
        node.stop()
    old, new = runs(tmp_path)
    assert old.name == RUNS[0]
    assert any(job_id.encode() in data for topic, data in raw(new) if topic == on_topic("answers"))
    with cell_of(domain, tmp_path, "damaged") as (node, client):
        assert "not all of" not in node.log
        assert latched(client, "good").part_digest == digest
