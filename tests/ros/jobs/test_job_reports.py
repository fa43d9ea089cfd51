"""Jobs that are looked at while they let go of their part."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from dataclasses import replace
from types import SimpleNamespace

import pytest
from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import JobEvent

from ros_pose_stats import simulate
from ros_pose_stats.errors import MeshError
from ros_pose_stats.recording.conflicts import read_conflicts
from ros_pose_stats.ros.jobs import Job, State
from ros_pose_stats.ros.jobs.job_reports import JobReports, job_event
from ros_pose_stats.ros.settings import Settings

from ..harness.parts import WEDGE, library_part
from .fake_jobs import Listener, asked, queue_of, settings, submit


def reports():
    """With stores and a recorder that know nothing and keep nothing."""
    parts = SimpleNamespace(current=lambda part_id: None)
    announcer = SimpleNamespace(record_answer=lambda message, **how: None)
    return JobReports(SimpleNamespace(parts=parts, number_result=lambda *args: args,
                                      announcer=announcer),
                      SimpleNamespace(record=lambda *args, **how: True), print)


def job_of(part, **request):
    return Job("run_0001", asked(**request), part, 1, settings())


def in_time(look):
    """What a look gives, which must not wait for anything."""
    found = []
    thread = threading.Thread(target=lambda: found.append(look()), daemon=True)
    thread.start()
    thread.join(30.0)
    assert found, "it waits"
    return found[0]


class Treacherous(Future):
    """A part that its job lets go of at the first look."""

    def done(self):
        self.job.release()
        return super().done()


@pytest.mark.parametrize("look", [
    lambda job: job_event(job, 3), lambda job: job.part_id,
    lambda job: reports().current_answer(job)])
def test_a_job_that_lets_go_of_its_part_meanwhile(look):
    part = library_part(WEDGE, "part")
    future = Treacherous()
    future.set_result(part)
    job = job_of(future, part_id="")
    job.snapshot = simulate(part, 10, seed=1)
    future.job = SimpleNamespace(release=lambda: setattr(job, "part", Future()))
    in_time(lambda: look(job) or "nothing")


def test_a_nameless_part_keeps_the_name_it_got():
    future = Future()
    job = job_of(future, part_id="")
    assert job.part_id == ""
    future.set_result(library_part(WEDGE))
    name = library_part(WEDGE).part_id
    assert job.part_id == name
    job.release()
    assert job.part_id == name


def test_the_end_of_a_job_whose_part_is_none_goes_on_record():
    future = Future()
    future.set_exception(MeshError("a solid", "a sheet", "close it"))
    job = job_of(future)
    job.message = "expected a solid, got a sheet; close it"
    recorded = []
    found = reports()
    found._recorder.record = lambda topic, data, durable: recorded.append(topic) or True
    found.ended(job, State.FAILED)
    assert recorded == ["/pose_stats/job_events"]


@pytest.mark.parametrize(("accepted", "ended"), [(True, True), (True, False), (False, True)])
def test_a_job_with_nothing_to_show_says_itself_what_is_not_on_record(accepted, ended):
    looked_at = reports()
    looked_at._recorder = SimpleNamespace(record=lambda *args, **how: ended)
    looked_at._results.announcer = SimpleNamespace(not_recorded=lambda: "NOT_RECORDED: full")
    job = job_of(Future())
    job.recorded, job.message = accepted, "cancelled by a client"
    looked_at.ended(job, State.CANCELLED)
    assert job.message.startswith("cancelled by a client")
    assert ("NOT_RECORDED: " in job.message) == (not (accepted and ended))


def test_an_unfinished_job_is_recorded_again_until_its_end_is():
    """Else the file that holds its acceptance might go while its end is on its way."""
    found, job = reports(), job_of(Future())
    recorder, events = found._recorder, []
    recorder.mark = recorder.trusted_from = 0

    def record(topic, data, durable):
        event = deserialize_message(data, JobEvent).event
        if event == JobEvent.CANCELLED:
            recorder.mark = recorder.trusted_from = 1
            again = threading.Thread(target=found.record_again)
            again.start()
            again.join(0.3)
            assert again.is_alive(), "it goes on without the job"
            waiting.append(again)
        events.append(event)
        return True

    waiting = []
    recorder.record = record
    found.queued(job)
    found.ended(job, State.CANCELLED)
    waiting[0].join()
    assert events == [JobEvent.QUEUED, JobEvent.CANCELLED]


class Disk:
    """A recorder that notes which events wait for the disk."""

    def __init__(self):
        self.durable, self.synced, self.mark = [], 0, 0

    def record(self, topic, data, *, durable):
        self.durable.append(durable)
        return True

    def sync(self):
        self.synced += 1
        return True


@pytest.mark.parametrize(("refinement", "waits"), [(False, True), (True, False)])
def test_what_nobody_was_told_of_does_not_wait_for_the_disk(refinement, waits):
    looked_at = reports()
    looked_at._recorder = disk = Disk()
    job = job_of(Future(), refinement=refinement)
    job.asked = not refinement
    looked_at.queued(job)
    looked_at.ended(job, State.CANCELLED)
    assert disk.durable == [waits, waits]


def test_a_refinement_that_a_client_joins_is_on_disk_before_they_are_told(monkeypatch):
    with queue_of(monkeypatch, listener := Listener(), started=False) as (jobs, _):
        first = submit(jobs, refinement=True, hybrid=True)
        assert submit(jobs, refinement=True, hybrid=True) is first
        assert listener.of(first) == ["queued"] and not first.asked
        assert submit(jobs, hybrid=True) is submit(jobs, hybrid=True) is first
        assert listener.of(first) == ["queued", "joined"] and first.asked
    looked_at = reports()
    looked_at._recorder = disk = Disk()
    assert looked_at.joined(first) and disk.synced == 1


class TestAContradictedEstimate:
    @pytest.fixture
    def job(self, tmp_path):
        part = library_part(WEDGE, "part")
        future = Future()
        future.set_result(part)
        job = Job("run_0001", asked(), future, 1, Settings(log_directory=str(tmp_path)))
        found = simulate(part, 50, seed=1)
        job.snapshot = replace(found, warnings=(*found.warnings, "CONFLICT: one."))
        return job

    def test_is_kept_for_training(self, job, tmp_path):
        reports().ended(job, State.DONE)
        (case,) = read_conflicts(tmp_path / "conflicts")
        assert (case.part.digest, case.counts.sum()) == (job.built().digest, 50)

    def test_that_cannot_be_kept_is_said(self, job, tmp_path, capsys):
        (tmp_path / "conflicts").write_text("in the way")
        reports().ended(job, State.DONE)
        assert "not kept for training" in capsys.readouterr().out

    def test_no_other_job_leaves_anything(self, job, tmp_path):
        job.snapshot = replace(job.snapshot, warnings=())
        reports().ended(job, State.DONE)
        assert list(tmp_path.iterdir()) == []
