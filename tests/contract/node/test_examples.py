"""The installed examples as a user runs them: processes beside a node, and their decisions."""

from __future__ import annotations

import contextlib
import io
import itertools
import re
import signal
import subprocess
import sys
import threading
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pytest
import rclpy

from ros_pose_stats import load_part, simulate
from tests.running import answer, complaints

from .harness.cell import cell_of, latched
from .harness.client import until
from .harness.node import PATIENCE, parameters
from .harness.parts import probabilities

EXECUTABLES = {script.name: script for script in entry_points(group="console_scripts")}
PLATE = {"restitution": 0.1, "drop_height": 0.04}
PARTS, RATE, CYCLE = 400, 60.0, 0.5


class Example:
    """An example in a process of its own, and the lines that it prints."""

    def __init__(self, name, namespace="", **values):
        self.process = subprocess.Popen(
            [Path(sys.executable).with_name(f"example_{name}"), "--ros-args",
             "-r", f"__ns:=/{namespace}", *parameters(**values)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.lines = []
        self._reader = threading.Thread(target=lambda: self.lines.extend(
            iter(self.process.stdout.readline, "")))
        self._reader.start()

    def says(self, text):
        """Wait until a line holds `text`."""
        def said():
            assert self.process.poll() is None, self.process.stderr.read()
            return next((line for line in self.lines if text in line), None)

        return until(said, f"{text!r} after {self.lines}")

    def end(self, number):
        """Its exit status and its complaints."""
        self.process.send_signal(number)
        status = self.process.wait(PATIENCE)
        return status, complaints(self.process.stderr.read())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self._reader.join()
        self.process.stdout.close()
        self.process.stderr.close()


@pytest.fixture(scope="module")
def part(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cad")
    answer("shapes", folder)
    return next(folder.glob("bracket.*"))


def far_from(truth, found):
    """Root mean square error over the poses."""
    told, true = probabilities(found.poses), probabilities(truth.poses)
    return float(np.sqrt(np.mean([(told[index] - true[index]) ** 2 for index in true])))


def best_flips(shares, moves, wanted):
    """The policy of all that takes least time, each by solving its equations."""
    poses = len(shares)
    wrong = sorted(set(range(poses)) - wanted)

    def seconds(flipped):
        """From each pose: t = cost + moves t, for flips and drops, and 0 where it is picked."""
        rows = np.array([moves[k] if k in flipped else shares for k in range(poses)])
        cost = np.array([CYCLE if k in flipped else 60.0 / RATE for k in range(poses)])
        rows[list(wanted)], cost[list(wanted)] = 0.0, 0.0
        return np.linalg.solve(np.eye(poses) - rows, cost).sum()

    policies = [set(chosen) for size in range(len(wrong) + 1)
                for chosen in itertools.combinations(wrong, size)]
    return min(policies, key=seconds)


@pytest.mark.long
def test_the_node_learns_the_plate_and_the_planner_picks_other_poses(domain, tmp_path, part):
    """Of this part the model has pose 1 before pose 2, and the plate has it the other way round.

    The counts of 400 parts alone would be 2 points from the truth, the model is 5 points off. Both
    examples are there before the node: their meshes are latched.
    """
    with Example("planner", "shown", files=f"['{part}']", unit="mm", kick_height=0.01,
                 rate=RATE, cycle_time=CYCLE) as planner, \
            Example("camera", "shown", file=part, unit="mm", batch=20, period=0.05,
                    **PLATE) as camera, \
            cell_of(domain, tmp_path, "shown") as (node, client):
        first = planner.says("bracket: ")
        assert "pick [0, 1]" in first and "split, 0 parts seen" in first
        with client.late_joiner() as joiner:
            learned = joiner.wait("bracket", lambda result: result.observed >= PARTS)
        assert learned.method == "observed"
        planner.says("pick [0, 2]")
        assert camera.end(signal.SIGINT) == (0, [])

        def policy_is_best():
            shares = np.array([share for _, share in sorted(
                probabilities(latched(client, "bracket").poses).items())])
            asked = client.good("feeding", part_id="bracket", wanted=[0, 2], rate=RATE,
                                kick_height=0.01, cycle_time=CYCLE)
            best = best_flips(shares, np.reshape(asked.transition, (len(shares), -1)), {0, 2})
            told = re.search(r"pick \[0, 2\], flip \[(.*?)\]", planner.lines[-1])
            return told and {int(one) for one in told[1].split(",") if one} == best

        until(policy_is_best, "the best of all policies")
        assert planner.end(signal.SIGTERM) == (0, [])
        model = client.good("estimate", part_id="bracket", method="split").statistics
        node.assert_sound()
    truth = simulate(load_part(part, unit="mm"), 5000, seed=1, **PLATE)
    assert far_from(truth, model) > 0.04
    assert far_from(truth, learned) < 0.5 * far_from(truth, model)


@pytest.mark.parametrize(("name", "values", "said"), [
    ("planner", {}, "files"),
    ("planner", {"files": "[missing.stl]"}, "missing.stl"),
    ("planner", {"files": "clamp.stl"}, "STRING_ARRAY"),
    ("planner", {"files": "[["}, "parse"),
    ("camera", {}, "file:="),
    ("camera", {"file": "missing.stl"}, "missing.stl"),
    ("camera", {"file": "{part}", "restitution": 1.5}, "restitution"),
    ("camera", {"file": "{part}", "misread": 2.0}, "misread"),
    ("camera", {"file": "{part}", "batch": 0}, "drops"),
])
def test_bad_arguments_are_told_in_one_line(domain, part, monkeypatch, name, values, said):
    values = {key: str(value).format(part=part) for key, value in values.items()}
    monkeypatch.setattr(sys, "argv", [name, "--ros-args", *parameters(**values)])
    stderr = io.StringIO()
    try:
        with contextlib.redirect_stderr(stderr):
            status = EXECUTABLES[f"example_{name}"].load()()
    finally:
        rclpy.try_shutdown()
    [line] = complaints(stderr.getvalue())
    assert status == 2
    assert line.startswith(f"example_{name}: ") and said in line
