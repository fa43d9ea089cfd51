"""The repository builds with colcon, as in an ordinary Jazzy workspace."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TAKEN = (
    "package.xml",
    "setup.py",
    "setup.cfg",
    "README.md",
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
    outcome = colcon(
        home,
        "build",
        "--base-paths",
        "src/ros_pose_stats",
        "src/ros_pose_stats/msg_defs",
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
def test_a_bare_build_finds_only_the_root_package(tmp_path):
    for name in TAKEN:
        copy(ROOT / name, tmp_path)
    packages = colcon(tmp_path, "list", "--names-only")
    assert packages.stdout.split() == ["ros_pose_stats"], packages.stderr
