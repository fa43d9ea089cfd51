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

"""Build of the ROS 2 Python package `ros_pose_stats`."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = "ros_pose_stats"
here = Path(__file__).resolve().parent
version: dict[str, str] = {}
exec((here / PACKAGE / "base" / "version.py").read_text(encoding="utf-8"), version)

setup(
    name=PACKAGE,
    version=version["VERSION"],
    description="Stable poses of parts on a feeder plate and their resting probabilities.",
    license="Apache-2.0",
    maintainer="ros_pose_stats maintainers",
    maintainer_email="maintainers@users.noreply.github.com",
    python_requires=">=3.10",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={
        PACKAGE: ["py.typed"],
        f"{PACKAGE}.tools.report": ["assets/*"],
        f"{PACKAGE}.tools.catalogue": ["assets/*"],
        f"{PACKAGE}.tools.watching": ["assets/*"],
        f"{PACKAGE}.core.estimators": ["weights/*.npz"],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/launch", ["launch/pose_stats.launch.py"]),
        (
            f"share/{PACKAGE}/config",
            [
                "config/pose_stats.policy.xml",
                "config/pose_stats.yaml",
                "config/pose_stats.rviz",
                "config/pose_stats.foxglove.json",
            ],
        ),
    ],
    install_requires=[
        "setuptools",
        "numpy>=1.26",
        "scipy>=1.11",
        "numba>=0.60,<0.69",
        "trimesh>=4.4",
        "lxml",
        "networkx",
        "manifold3d>=3.2",
        "mcap>=1.2.1",
        "mcap-ros2-support>=0.5.3",
        "zstandard",
        "lz4",
        "PyYAML",
    ],
    extras_require={
        "tools": ["matplotlib>=3.6", "pillow", "Jinja2", "shtab>=1.13"],
        "test": ["pytest", "hypothesis"],
        "cluster": ["distributed>=2024.1"],
        "step": ["cascadio>=0.1.1"],
        "parquet": ["pyarrow>=14"],
    },
    entry_points={
        "console_scripts": [
            f"{PACKAGE} = {PACKAGE}.tools.cli:main",
            f"pose_stats_node = {PACKAGE}.node.entry:main",
            f"example_planner = {PACKAGE}.node.examples.planner:main",
            f"example_camera = {PACKAGE}.node.examples.camera:main",
        ]
    },
    zip_safe=False,
)
