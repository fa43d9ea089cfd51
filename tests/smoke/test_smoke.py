# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""What `colcon test` runs in any workspace: imports, launch, and a node that answers.

With any pytest from 7.4 on and nothing but what the package needs. The kernels must
have been compiled before (`ros2 run ros_pose_stats ros_pose_stats compile`), which else
takes this a few minutes.
"""

import json
import os
import pkgutil
import signal
import subprocess
import sys
from contextlib import suppress
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

import ros_pose_stats
from ros_pose_stats.base.errors import RequestError

ROOT = Path(__file__).resolve().parents[2]
LAUNCH_FILE = ROOT / "launch/pose_stats.launch.py"
COMMAND = (sys.executable, "-m", "ros_pose_stats")
ANSWER_SECONDS = 600  # for a node to answer, which may compile kernels before


def test_all_modules_of_the_node_and_the_commands_can_be_imported():
    names = [
        module.name
        for module in pkgutil.walk_packages(
            ros_pose_stats.__path__, f"{ros_pose_stats.__name__}."
        )
        if not module.name.endswith("__main__")
    ]
    for name in names:
        with suppress(RequestError):  # of an extra that is not installed
            import_module(name)
    assert len(names) > 200


@pytest.fixture
def launch_file():
    """The launch file as a module."""
    pytest.importorskip("launch_ros.actions")
    spec = spec_from_file_location("pose_stats_launch", LAUNCH_FILE)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def launch(launch_file, tmp_path, monkeypatch):
    """A function that launches with arguments.

    It returns launch's status, the statuses of all processes that have ended, and what
    launch complained of.
    """
    from launch.actions import RegisterEventHandler, SetLaunchConfiguration
    from launch.event_handlers import OnProcessExit

    from launch import LaunchDescription, LaunchService

    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))

    def run(**arguments):
        statuses = []
        watch = OnProcessExit(
            on_exit=lambda event, context: statuses.append(event.returncode)
        )
        settings = [
            SetLaunchConfiguration(name, str(value))
            for name, value in arguments.items()
        ]
        service = LaunchService()
        service.include_launch_description(
            LaunchDescription([RegisterEventHandler(watch), *settings])
        )
        service.include_launch_description(launch_file.generate_launch_description())
        return service.run(), statuses

    return run


@pytest.fixture
def parameters(tmp_path):
    """A function that writes a file of parameters."""

    def write(**values):
        file = tmp_path / "parameters.yaml"
        values = {"log_directory": str(tmp_path / "bags"), **values}
        file.write_text(json.dumps({"/**": {"ros__parameters": values}}))
        return file

    return write


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"rviz": "true"}, "expected the package rviz2 for rviz:=true, got none"),
        ({"params_file": "/no/such.yaml"}, "got '/no/such.yaml', which is none"),
        ({"respawn_max_retries": "many"}, "a whole number, got 'many'"),
    ],
)
def test_launch_refuses_before_it_starts_anything(
    launch, parameters, monkeypatch, tmp_path, capfd, arguments, words
):
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    status, statuses = launch(**{"params_file": parameters(), **arguments})
    assert (status, statuses) == (1, [])
    printed = "".join(capfd.readouterr())
    assert words in printed


def is_installed():
    """Whether launch finds the package's executables."""
    packages = pytest.importorskip("ament_index_python.packages")
    try:
        packages.get_package_prefix("ros_pose_stats")
    except packages.PackageNotFoundError:
        return False
    return True


def test_launch_does_not_start_a_node_again_that_refuses_its_parameters(
    launch, parameters
):
    if not is_installed():
        pytest.skip("ros_pose_stats is not installed in a workspace")
    file = parameters(restitution=3.0)
    _, statuses = launch(params_file=file, respawn="true", namespace="smoke")
    assert statuses == [2]


def test_a_node_starts_and_answers_and_ends(tmp_path):
    environment = {
        **os.environ,
        "ROS_DOMAIN_ID": str(1 + os.getpid() % 100),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(tmp_path / "log"),
    }
    subprocess.run([*COMMAND, "shapes", tmp_path / "parts"], check=True)
    settings = ["--ros-args", "-p", f"log_directory:={tmp_path / 'bags'}"]
    node = subprocess.Popen([*COMMAND, "node", *settings], env=environment)
    try:
        file = tmp_path / "parts/clamp.stl"
        words = ["publish", file, "--unit", "mm", "--json", "--seconds"]
        answer = subprocess.run(
            [*COMMAND, *words, str(ANSWER_SECONDS)],
            env=environment,
            capture_output=True,
            check=True,
        )
        node.send_signal(signal.SIGINT)
        assert node.wait(timeout=60) == 0
    finally:
        node.kill()
        node.wait()
    statistics = json.loads(answer.stdout)
    shares = [pose["probability"] for pose in statistics["poses"]]
    assert len(shares) > 1
    assert abs(sum(shares) - 1.0) < 1e-9
