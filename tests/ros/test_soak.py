"""A short soak of the node, and the judges of the long one."""

from __future__ import annotations

import pytest
from ros_pose_stats_msgs.msg import JobEvent, PoseStatistics

from benchmarks.report import table
from ros_pose_stats.recording.writer.run_log import RunLog
from ros_pose_stats.ros.recorder import bag_types
from tests.soak.node import checks, run
from tests.soak.node.bodies import BODIES, counted, estimated, prefixes, simulated
from tests.soak.node.tally import Simulated, Tally, key_of

from .restart.test_last_run_damage import bytes_of

MINUTES = 0.3
GIGABYTE = 2**30

FAULTS = {"disk full", "log directory moved away", "clock set back an hour",
          "client killed in a call", "job that fails", run.KILLED, run.STOPPED}


@pytest.mark.long
def test_a_third_of_a_minute():
    tally, tables = run.soak(MINUTES)
    assert tally.wrong == []
    assert set(tally.faults) == FAULTS
    by_name = {section.name: section for section in tables}
    assert all(target.met for row in by_name["soak_checks"].rows for target in row.targets)
    assert all(row.cells["of"] > 20 for row in by_name["soak_checks"].rows)
    assert len({sample.life for sample in tally.samples}) == len(run.plan(MINUTES))
    assert max(sample.bytes for sample in tally.samples) < GIGABYTE
    assert tally.unrecorded and tally.refusals and tally.diagnostics["refused"]
    assert len({call for call in tally.seconds if tally.seconds[call]}) == 10
    assert all(table(section).count("\n") > 2 for section in tables)


class TestPlan:
    @pytest.mark.parametrize("minutes", [0.1, 1.0, 5.0])
    def test_takes_the_time_and_ends_some_lives(self, minutes):
        spans = run.plan(minutes)
        assert sum(span.seconds for span in spans) == pytest.approx(60.0 * minutes)
        assert {span.end for span in spans[:-1]} == {run.KILLED, run.STOPPED}
        assert spans[-1].end == "" and spans[-1].seconds > spans[0].seconds


class TestJudges:
    """Each finds what is wrong."""

    def test_estimates(self):
        tally, key = Tally(), (1, "csae", 0.5)
        tally.estimates = [(key, dict(estimated(*key)))]
        assert checks.compare_estimates(tally) == 0
        tally.estimates[0][1][0] += 1e-15
        assert checks.compare_estimates(tally) == 1 and tally.wrong

    @pytest.mark.parametrize("asked", [60, 1000])
    def test_simulations_to_their_end_or_cut(self, asked):
        key, counts = Simulated(1, 0.5, 3, asked, 60), dict(simulated(1, 60, 0.5, 3))
        tally = Tally(simulations={key: counts})
        assert checks.compare_simulations(tally) == 0
        counts[next(iter(counts))] += 1
        assert checks.compare_simulations(tally) == 1 and tally.wrong

    def test_prefixes_are_simulations(self):
        found = prefixes(2, 0.2, 5, [7, 90])
        assert found == {size: simulated(2, size, 0.2, 5) for size in (7, 90)}

    def test_bags(self, tmp_path):
        told = PoseStatistics(part_id="part", revision=3)
        log = RunLog(tmp_path, bag_types(), max_bag_bytes=1 << 29)
        write_to(log, "answers", told)
        for kind, job_id in ((JobEvent.QUEUED, "a"), (JobEvent.QUEUED, "b"), (JobEvent.DONE, "a")):
            write_to(log, "job_events", JobEvent(event=kind, job_id=job_id))
        log.close()
        tally = Tally(answers={key_of(told)}, accepted={"a", "b"}, ends={"a": 5})
        found = checks.recorded([tmp_path], tally)
        assert (found.bags, found.messages, found.lost, found.unfinished) == (1, 4, 0, 1)
        tally.answers.add(key_of(PoseStatistics(part_id="part", revision=4)))
        tally.accepted.add("c")
        tally.ends["b"] = 1
        assert checks.recorded([tmp_path], tally).lost == 3 and len(tally.wrong) == 3

    def test_answers_that_are_not_on_record_are_not_acknowledged(self):
        tally = Tally()
        assert not tally.told(PoseStatistics(warnings=["NOT_RECORDED: full"]))
        assert tally.told(PoseStatistics()) and len(tally.answers) == tally.unrecorded == 1

    def test_refusals_in_many_lines_are_wrong(self):
        tally = Tally()
        tally.refuse("expected 1 to 2 (a, b), got 7; do not")
        assert tally.wrong == [] and dict(tally.refusals) == {"N to N": 1}
        tally.refuse("two\nlines")
        assert len(tally.wrong) == 1


def write_to(log, topic, message):
    log.write(f"/pose_stats/{topic}", bytes_of(message), durable=False)


def test_bodies_have_counts():
    assert all(sum(counted(body_statistics(number)).values()) == 50
               for number in range(len(BODIES)))


def body_statistics(number):
    from ros_pose_stats import simulate

    return simulate(BODIES[number].part, 50, seed=1, workers=1)
