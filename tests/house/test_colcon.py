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

"""The repository builds with colcon, as in a Jazzy workspace, and as a wheel."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
TAKEN = (
    "package.xml",
    "setup.py",
    "setup.cfg",
    "README.md",
    "LICENSE",
    "resource",
    "launch",
    "config",
    "ros_pose_stats",
    "msg_defs",
)
MEND = ROOT / ".ci/drop_missing_include_dirs.cmake"


def copy(item, folder):
    """A file or a folder with all that is in it."""
    if item.is_dir():
        shutil.copytree(item, folder / item.name)
    else:
        shutil.copy(item, folder)


@pytest.fixture(scope="module")
def workspace(tmp_path_factory):
    """A workspace with both packages built."""
    home = tmp_path_factory.mktemp("workspace")
    source = home / "src/ros_pose_stats"
    source.mkdir(parents=True)
    for name in TAKEN:
        copy(ROOT / name, source)
    (source / "tests").mkdir()
    copy(ROOT / "tests/smoke", source / "tests")
    # colcon and rosdep look for no packages inside of a package.
    (home / "src/ros_pose_stats_msgs").symlink_to("ros_pose_stats/msg_defs")
    outcome = colcon(
        home,
        "build",
        "--cmake-args",
        f"-DPython3_EXECUTABLE={sys.executable}",
        "-DBUILD_TESTING=OFF",
        f"-DCMAKE_PROJECT_INCLUDE={MEND}",
    )
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
    return home


def colcon(home, *arguments):
    prefix = sys.prefix
    environment = {
        **os.environ,
        "AMENT_PREFIX_PATH": prefix,
        "CMAKE_PREFIX_PATH": prefix,
        "PATH": f"{prefix}/bin:{os.environ['PATH']}",
        "CMAKE_BUILD_PARALLEL_LEVEL": "2",
    }
    return subprocess.run(
        [sys.executable, "-m", "colcon", *arguments],
        cwd=home,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.long
def test_both_packages_are_installed_and_run(workspace):
    install = workspace / "install"
    assert (
        install / "ros_pose_stats_msgs/share/ros_pose_stats_msgs/msg/PartMesh.msg"
    ).is_file()
    assert (install / "ros_pose_stats/share/ros_pose_stats/package.xml").is_file()
    assert (
        install / "ros_pose_stats/share/ros_pose_stats/launch/pose_stats.launch.py"
    ).is_file()
    for name in ("yaml", "rviz", "foxglove.json"):
        file = f"ros_pose_stats/share/ros_pose_stats/config/pose_stats.{name}"
        assert (install / file).is_file()
    assets = list((install / "ros_pose_stats").rglob("report/assets/*"))
    ours = (ROOT / "ros_pose_stats/tools/report/assets").iterdir()
    assert {file.name for file in assets} == {file.name for file in ours} > {"page.css"}
    index = "share/ament_index/resource_index"
    assert (install / f"ros_pose_stats/{index}/packages/ros_pose_stats").is_file()
    assert (
        install / f"ros_pose_stats_msgs/{index}/packages/ros_pose_stats_msgs"
    ).is_file()
    # Where `ros2 run` looks, and the Python that it then takes: the one that ran
    # colcon.
    for name in (
        "pose_stats_node",
        "ros_pose_stats",
        "example_planner",
        "example_camera",
    ):
        executable = install / "ros_pose_stats/lib/ros_pose_stats" / name
        assert os.access(executable, os.X_OK)
        assert executable.read_text(encoding="utf-8").startswith(
            f"#!{sys.executable}\n"
        )


@pytest.mark.long
def test_colcon_runs_the_smoke_set(workspace):
    outcome = colcon(workspace, "test")
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
    results = workspace / "build/ros_pose_stats/pytest.xml"
    cases = list(ElementTree.parse(results).getroot().iter("testcase"))
    skipped = {case.get("name") for case in cases if case.find("skipped") is not None}
    # No wheel has launch.
    assert all("launch" in name for name in skipped)
    assert len(cases) > len(skipped) > 0
    outcome = colcon(workspace, "test-result", "--verbose")
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
    assert "0 errors, 0 failures" in outcome.stdout


@pytest.fixture(scope="module")
def bare_environment(tmp_path_factory):
    """The Python of an environment with a wheel of the package, and its site-packages.

    What the package needs is that of our own environment, behind the environment's own.
    """
    folder = tmp_path_factory.mktemp("bare")
    source = folder / "source"
    source.mkdir()
    for name in TAKEN:
        copy(ROOT / name, source)
    pip = [sys.executable, "-m", "pip"]
    options = ["--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*pip, "wheel", *options, "-w", folder, source], check=True)
    (wheel,) = folder.glob("*.whl")
    subprocess.run(
        [sys.executable, "-m", "venv", "--without-pip", folder / "venv"], check=True
    )
    python = folder / "venv/bin/python"
    (packages,) = (folder / "venv/lib").glob("python3.*/site-packages")
    subprocess.run(
        [*pip, "--python", python, "install", *options, "--no-index", wheel], check=True
    )
    ours = Path(pytest.__file__).resolve().parents[1]
    (packages / "ours.pth").write_text(f"{ours}\n", encoding="utf-8")
    return python, packages


def printed_by(command, folder, environment):
    """What a command prints that is to succeed there, in that environment alone."""
    outcome = subprocess.run(
        command,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
    return outcome.stdout


@pytest.mark.long
def test_wheel_and_built_messages_are_a_node_that_answers(
    workspace, bare_environment, tmp_path
):
    """The smoke set, with nothing of this checkout; no wheel has messages."""
    python, packages = bare_environment
    install = workspace / "install/ros_pose_stats_msgs"
    (messages,) = install.glob("lib/python3.*/site-packages")
    environment = {
        "HOME": os.environ["HOME"],
        "PATH": os.environ["PATH"],
        "PYTHONPATH": str(messages),
        "AMENT_PREFIX_PATH": f"{install}:{sys.prefix}",
        "LD_LIBRARY_PATH": f"{install}/lib:{os.environ['LD_LIBRARY_PATH']}",
    }

    def run(*words):
        return printed_by([python, *words], tmp_path, environment)

    places = "print(ros_pose_stats.__path__[0], ros_pose_stats_msgs.__path__[0])"
    imported = run("-c", f"import ros_pose_stats, ros_pose_stats_msgs; {places}")
    assert imported.split() == [
        str(packages / "ros_pose_stats"),
        str(messages / "ros_pose_stats_msgs"),
    ]
    smoke = workspace / "src/ros_pose_stats/tests/smoke/test_smoke.py"
    printed = run("-m", "pytest", "-c", os.devnull, "--rootdir", tmp_path, smoke)
    assert " passed" in printed and "failed" not in printed


@pytest.mark.long
def test_a_wheel_has_all_that_the_command_needs(bare_environment, tmp_path):
    """Weights, assets of pages, and the type information, too."""
    python, packages = bare_environment
    environment = {key: os.environ[key] for key in ("HOME", "PATH")}
    command = python.with_name("ros_pose_stats")

    def run(*words):
        return printed_by([command, *words], tmp_path, environment)

    run("shapes", "parts")
    answer = json.loads(run("estimate", "parts/clamp.stl", "--unit", "mm", "--json"))
    assert len(answer["poses"]) > 1
    run("report", "parts/clamp.stl", "--unit", "mm", "-o", "clamp.html")
    package = packages / "ros_pose_stats"
    sources = {
        file.relative_to(ROOT)
        for file in (ROOT / "ros_pose_stats").rglob("*")
        if file.is_file() and file.suffix not in (".pyc", ".nbi", ".nbc")
    }
    installed = {
        file.relative_to(packages)
        for file in package.rglob("*")
        if file.is_file() and file.suffix != ".pyc"
    }
    assert installed == sources
