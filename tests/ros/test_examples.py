"""The installed examples as a user runs them: processes beside a node, and their decisions."""

from __future__ import annotations

import itertools
import signal
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ros_pose_stats import load_part, simulate
from ros_pose_stats.ros import examples
from ros_pose_stats.ros.examples.camera import multiply
from ros_pose_stats.ros.examples.planner import ExamplePlanner
from ros_pose_stats.shapes.demo_parts import bracket
from tests.bodies import write_stl
from tests.running import complaints

from .harness.cell import cell_of, latched
from .harness.client import until
from .harness.node import PATIENCE, parameters
from .harness.parts import probabilities

PLATE = {"restitution": 0.1, "drop_height": 0.04}
PARTS = 400


class Example:
    """An example in a process of its own, and the lines that it prints."""

    def __init__(self, name, namespace="", **values):
        self.process = subprocess.Popen(
            [sys.executable, "-m", f"ros_pose_stats.ros.examples.{name}", "--ros-args",
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

    def end(self, number=None):
        """Its exit status and its complaints."""
        if number is not None:
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
    vertices, triangles = bracket()
    return write_stl(tmp_path_factory.mktemp("cad") / "bracket.stl", (vertices, triangles))


def far_from(truth, found):
    """Root mean square over the poses."""
    told, true = probabilities(found.poses), probabilities(truth.poses)
    return float(np.sqrt(np.mean([(told[index] - true[index]) ** 2 for index in true])))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_node_learns_the_plate_and_the_planner_picks_other_poses(domain, tmp_path, part,
                                                                     number):
    """Of this part the model has pose 1 before pose 2, and the plate has it the other way round.

    The counts of 400 parts alone would be 2 points from the truth, the model is 5 points off.
    """
    name = f"shown{number}"
    with Example("planner", name, files=f"['{part}']", kick_height=0.01) as planner, \
            Example("camera", name, file=part, batch=20, period=0.05, **PLATE) as camera, \
            cell_of(domain, tmp_path, name) as (node, client):
        first = planner.says("bracket: ")
        assert "pick [0, 1]" in first and "split, 0 parts seen" in first
        with client.late_joiner() as joiner:
            learned = joiner.wait("bracket", lambda result: result.observed >= PARTS)
        assert learned.method == "observed"
        planner.says("pick [0, 2]")
        assert camera.end(number) == (0, [])
        assert planner.end(number) == (0, [])
        model = client.good("estimate", part_id="bracket", method="split").statistics
        assert latched(client, "bracket").observed >= PARTS
        node.assert_sound()
    truth = simulate(load_part(part), 5000, seed=1, **PLATE)
    assert far_from(truth, model) > 0.04
    assert far_from(truth, learned) < 0.5 * far_from(truth, model)


def test_a_node_that_begins_anew_is_given_the_parts_again(domain, tmp_path, part):
    with Example("planner", "again", files=f"['{part}']", rate=30.0) as planner:
        for run in range(2):
            with cell_of(domain, tmp_path / f"{run}", "again", restitution=0.5 - 0.4 * run) as (
                    _, client):
                assert latched(client, "bracket").part_digest == load_part(part).digest
                planner.says("bracket: pick")
        assert planner.end(signal.SIGINT) == (0, [])


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
def test_bad_arguments_are_told_in_one_line(domain, part, name, values, said):
    values = {key: str(value).format(part=part) for key, value in values.items()}
    with Example(name, "refused", **values) as example:
        status, lines = example.end()
    ours = [line for line in lines if not line.startswith("[ERROR]")]  # of rcl itself
    assert status == 2 and len(ours) == 1, lines
    assert ours[0].startswith(f"example_{name}: ") and said in ours[0]


@pytest.mark.parametrize("seed", range(20))
def test_flips_are_those_of_the_best_of_all_policies(seed):
    """Each policy's time by solving its equations; the planner iterates values."""
    random = np.random.default_rng(seed)
    poses, wanted = 5, {1, 3}
    probability = random.dirichlet(np.ones(poses))
    transition = random.dirichlet(np.full(poses, 0.7), poses)
    drop, flip = 2.0, random.uniform(0.2, 4.0)
    wrong = sorted(set(range(poses)) - wanted)

    def seconds(flipped):
        """From each pose: t = cost + moves t, for flips and drops, and 0 where it is picked."""
        moves = np.array([transition[k] if k in flipped else probability for k in range(poses)])
        cost = np.array([flip if k in flipped else drop for k in range(poses)])
        moves[list(wanted)], cost[list(wanted)] = 0.0, 0.0
        return np.linalg.solve(np.eye(poses) - moves, cost)

    policies = [set(chosen) for size in range(4)
                for chosen in itertools.combinations(wrong, size)]
    best = min(policies, key=lambda flipped: seconds(flipped).sum())
    result = SimpleNamespace(poses=[SimpleNamespace(index=index, probability=probability[index])
                                    for index in np.argsort(-probability).tolist()])
    planner = SimpleNamespace(rate=60.0 / drop, cycle_time=flip)
    found = ExamplePlanner.choose_flips(planner, result, transition.ravel(), wanted)
    assert found - wanted == best


def test_quaternions_are_multiplied():
    first, second = (Rotation.random(50, random_state=seed) for seed in (1, 2))
    np.testing.assert_allclose(multiply(first.as_quat(), second.as_quat()),
                               _same_sign((first * second).as_quat(),
                                          multiply(first.as_quat(), second.as_quat())),
                               atol=1e-12)


def _same_sign(quaternions, like):
    """Of q and -q, which turn alike, the one that is like another."""
    return quaternions * np.sign((quaternions * like).sum(axis=1, keepdims=True))


@pytest.mark.parametrize("name", ["planner", "camera"])
def test_each_is_short_enough_to_be_copied(name):
    file = Path(examples.__file__).parent / f"{name}.py"
    assert len(file.read_text(encoding="utf-8").splitlines()) < 150
