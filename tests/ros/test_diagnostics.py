"""What the node says of its own health on /diagnostics."""

from __future__ import annotations

import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from .harness.cell import Health
from .harness.client import until
from .harness.goals import Goals
from .harness.jobs import LONG, known_part, running_with_results, start


@pytest.fixture(scope="module")
def health(shared_client):
    return Health(shared_client)


def test_its_lines_about_once_a_second(cell):
    heard = []
    subscription = cell.subscribe(DiagnosticArray, "/diagnostics", heard.append)

    def own():
        names = [[line.name for line in message.status] for message in heard]
        return [message for message, lines in zip(list(heard), names, strict=False)
                if lines[0].startswith("pose_stats: ")]

    until(lambda: len(own()) >= 3)
    cell.node.destroy_subscription(subscription)
    first, *_, last = own()
    assert [line.name for line in last.status] == [
        f"pose_stats: {about}" for about in ("parts", "counts", "jobs", "flips", "recording")]
    stamps = [message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
              for message in (first, last)]
    assert (stamps[1] - stamps[0]) / (len(own()) - 1) == pytest.approx(1.0, abs=0.5)
    assert stamps[1] == pytest.approx(time.time(), abs=5.0)


def test_parts(cell, health):
    known_part(cell)
    _, values = health.line("parts")
    assert {"parts", "meshes waiting", "refused", "overrun"} <= values.keys()
    assert int(values["parts"]) > 0 and values["meshes waiting"] == "0"


def test_queue_and_running_job(cell, health):
    line, values = health.line("jobs", lambda _, values: not values["running"])
    assert (line.message, values["queued"], values["refinements queued"]) == ("idle", "0", "0")
    part_id = known_part(cell)
    jobs = [start(cell, part_id, LONG, seed=seed) for seed in (1, 2, 3)]
    running_with_results(cell, jobs[0])
    line, values = health.line("jobs", lambda _, values: values["running"])
    assert (values["running"], values["queued"]) == (jobs[0], "2")
    assert values["queue bound"] == "16" and int(values["threads"]) > 0
    assert line.message.startswith(f"{jobs[0]}: ")
    assert line.message.endswith(f" of {LONG} drops of '{part_id}'")
    assert line.level == DiagnosticStatus.OK


def test_flips(cell, health):
    goals = Goals(cell, "simulate_flips")
    line, values = health.line("flips", lambda _, values: not values["running"])
    assert line.message == "idle"
    part_id = known_part(cell)
    sent = [goals.send(part_id=part_id, kick_height=0.012, drops=500_000, seed=seed)
            for seed in (1, 2)]
    line, values = health.line("flips", lambda _, values: values["running"])
    assert (values["goals queued"], values["answers queued"]) == ("1", "0")
    assert line.message.endswith(f"flips of '{part_id}'")
    for goal in reversed(sent):
        goal.cancel()
        goal.result()
    goals.close()


def test_recording(cell, shared_node, health):
    known_part(cell)
    line, values = health.line("recording")
    assert (line.level, line.message) == (DiagnosticStatus.OK, "recording")
    assert values["bag"].startswith(str(shared_node.log_directory))
    assert int(values["bytes written"]) > 0 and int(values["bytes left"]) > 0
    assert values["messages not recorded"] == "0"
    assert values["last repair"] == "none"
