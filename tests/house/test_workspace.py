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

"""The lines of docs/workspace.md, run as they stand there, in a workspace from nothing.

They take several minutes, so they run only where `WORKSPACE_PYTHON` names a Python 3.12
(Ubuntu 24.04's) to build on. An environment of it plays the distribution: Ubuntu's
versions and the wheels of ROS. What no wheel has is played by functions of the shell:
apt, rosdep, `ros2 run`. Where `JAZZY_SOURCES` names a folder with checkouts of launch,
launch_ros, osrf_pycommon and rcl_interfaces, the launch file is tried, too.
"""

import os
import re
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/workspace.md"
PYTHON = os.environ.get("WORKSPACE_PYTHON")
SOURCES = os.environ.get("JAZZY_SOURCES")
NOBLE = [
    "numpy==1.26.4",
    "scipy==1.11.4",
    "lxml==5.2.1",
    "networkx==2.8.8",
    "pillow==10.2.0",
    "Jinja2==3.1.2",
    "MarkupSafe==2.1.5",
    "PyYAML==6.0.1",
    "setuptools==68.1.2",
    "wheel==0.42.0",
    "pytest==7.4.4",
    "coverage==7.4.4",
    "matplotlib==3.8.0",
    "empy==3.3.4",
    "colcon-common-extensions==0.3.0",
]
"""What apt has on Ubuntu 24.04; matplotlib 3.6.3 has no wheel for Python 3.12."""

INTERFACES = "rcl_interfaces/composition_interfaces"
PURE_PYTHON = ["osrf_pycommon", "launch/launch", "launch_ros/launch_ros"]
DEFAULTS = """\
build:
  cmake-args: ["-DCMAKE_PROJECT_INCLUDE={include}"]
"""
STAND_INS = """\
set -eo pipefail
sudo() {{ :; }}
rosdep() {{ :; }}
ros2() {{ "install/$2/lib/$2/$3" "${{@:4}}"; }}
# An environment on top of another one sees only the packages below both.
python3() {{
    command python3 "$@"
    for packages in venv/lib/python3.*/site-packages; do
        echo 'import site; site.addsitedir("{packages}")' >"$packages/system.pth"
    done
}}
set -x
"""


def run(*command, **options):
    outcome = subprocess.run(
        command, capture_output=True, text=True, check=False, **options
    )
    assert outcome.returncode == 0, f"{outcome.stdout}\n{outcome.stderr}"
    return outcome.stdout


@pytest.fixture(scope="module")
def distribution(tmp_path_factory):
    """The folder of an environment that has what Ubuntu and its ROS have."""
    folder = tmp_path_factory.mktemp("distribution")
    run(PYTHON, "-m", "venv", folder)
    pip = [folder / "bin/python", "-m", "pip", "install", "--quiet"]
    run(*pip, *NOBLE)
    ros = ROOT / ".ci/requirements-ros.txt"
    run(*pip, "-r", ros, "-c", ROOT / ".ci/constraints-ros.txt")
    if SOURCES:
        for name in PURE_PYTHON:
            run(*pip, "--no-deps", "--no-build-isolation", f"{SOURCES}/{name}")
        build = folder / "build"
        environment = environment_of(folder)
        options = ["-DBUILD_TESTING=OFF", f"-DCMAKE_INSTALL_PREFIX={folder}"]
        options.append(f"-DCMAKE_PROJECT_INCLUDE={include_file()}")
        source = f"{SOURCES}/{INTERFACES}"
        run("cmake", "-S", source, "-B", build, *options, env=environment)
        run("cmake", "--build", build, "--target", "install", env=environment)
    return folder


def include_file():
    """What the wheels of ROS need of cmake, and Debian packages do not."""
    return ROOT / ".ci/drop_missing_include_dirs.cmake"


def environment_of(distribution):
    """Variables that a sourced ROS sets, and none of our own environment.

    The wheels look for their libraries where their Python is, and set that variable in
    every process; an environment on top of it would have them elsewhere.
    """
    return {
        "HOME": str(distribution.parent),
        "LANG": "C.UTF-8",
        "PATH": f"{distribution}/bin:/usr/bin:/bin",
        "AMENT_PREFIX_PATH": str(distribution),
        "CMAKE_PREFIX_PATH": str(distribution),
        "LD_LIBRARY_PATH": run(
            distribution / "bin/python",
            "-c",
            "import os; print(os.environ['LD_LIBRARY_PATH'])",
            env={},
        ).strip(),
        "ROS_VERSION": "2",
        "ROS_DISTRO": "jazzy",
        "CMAKE_BUILD_PARALLEL_LEVEL": "2",
    }


def lines_of_page():
    """The lines of the first two blocks of the page: set-up and tests."""
    blocks = re.findall(r"```sh\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    return "".join(blocks[:2])


@pytest.fixture(scope="module")
def workspace(distribution, tmp_path_factory):
    """The workspace after all lines, and what they printed."""
    home = tmp_path_factory.mktemp("home")
    defaults = home / "defaults.yaml"
    defaults.write_text(DEFAULTS.format(include=include_file()), encoding="utf-8")
    (packages,) = distribution.glob("lib/python3.*/site-packages")
    setup = home / "setup.bash"
    setup.touch()
    lines = lines_of_page().replace("/opt/ros/jazzy/setup.bash", str(setup))
    lines = lines.replace("git clone URL", f"git clone --quiet {ROOT}")
    script = STAND_INS.format(packages=packages) + lines
    environment = environment_of(distribution)
    environment["HOME"] = str(home)
    environment["COLCON_DEFAULTS_FILE"] = str(defaults)
    printed = run("bash", "-c", script, cwd=home, env=environment)
    return home / "workspace", printed


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.skipif(not PYTHON, reason="WORKSPACE_PYTHON names no Python to build on")
def test_the_lines_of_the_page_build_and_test_a_workspace(workspace):
    folder, printed = workspace
    results = folder / "build/ros_pose_stats/pytest.xml"
    cases = list(ElementTree.parse(results).getroot().iter("testcase"))
    outcomes = {case.get("name"): [child.tag for child in case] for case in cases}
    assert len(outcomes) >= 6
    skipped = {name for name, tags in outcomes.items() if tags}
    launch_tests = {name for name in outcomes if "launch" in name}
    assert skipped == (set() if SOURCES else launch_tests)
    assert "0 errors, 0 failures" in printed
    executable = folder / "install/ros_pose_stats/lib/ros_pose_stats/pose_stats_node"
    first_line = executable.read_text(encoding="utf-8").splitlines()[0]
    assert first_line == f"#!{folder}/venv/bin/python"
