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

"""Modules of others: what brings those that a Python may lack, and numpy's threads."""

import os
import sys
from importlib import import_module
from typing import NamedTuple

from .errors import RequestError


class Extra(NamedTuple):
    """What brings a module, and what the module is for."""

    name: str  # as in `pip install 'ros_pose_stats[NAME]'`
    purpose: str


EXTRAS = {
    "matplotlib": Extra("tools", "draws pictures"),
    "PIL": Extra("tools", "writes pictures"),
    "jinja2": Extra("tools", "writes pages"),
    "shtab": Extra("tools", "writes what Tab completes"),
    "cascadio": Extra("step", "reads STEP files"),
    "distributed": Extra("cluster", "reaches a cluster"),
    "pyarrow": Extra("parquet", "writes Parquet files"),
}


def keep_algebra_to_one_thread() -> None:
    """Keep OpenBLAS off the other cores, unless numpy is imported already.

    OpenBLAS reads the number of its threads once, as numpy is imported. They spin while
    they wait, on cores that simulate, and nothing here is large enough for them. A
    number that is already set is kept.
    """
    if "numpy" not in sys.modules:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def require_modules(*modules: str) -> None:
    """Import modules of extras.

    Raises
    ------
    RequestError
        If one of them cannot be imported; it says which extra to install.
    """
    for module in modules:
        try:
            import_module(module)
        except ImportError as error:
            raise missing_module(module, str(error)) from error


def missing_module(module: str, reason: str) -> RequestError:
    """The refusal of what needs a module that cannot be imported."""
    extra = EXTRAS[module.partition(".")[0]]
    return RequestError(
        f"the module {module}, which {extra.purpose}",
        f"none that can be imported ({reason})",
        f"install it with `pip install 'ros_pose_stats[{extra.name}]'`",
    )


PROJECTS = {"mcap_ros2": "mcap-ros2-support", "yaml": "PyYAML"}
"""What pip calls modules, where that is not their name."""

BUILT = ("ros_pose_stats_msgs", "rclpy")
"""What a sourced workspace brings, and no pip."""


def failed_import(error: ImportError) -> RequestError | None:
    """The refusal of a program whose Python lacks a module; None for one of our own.

    An ordinary `colcon build` writes the distribution's Python into the executables,
    which has not all that the package needs.
    """
    module = (error.name or "").partition(".")[0]
    if module == __name__.partition(".")[0]:
        return None
    remedy = (
        f"install it with `{sys.executable} -m pip install "
        f"{PROJECTS.get(module, module)}`, or build the workspace with a Python that "
        "has it, as docs/workspace.md says"
    )
    if module in BUILT:
        remedy = "build the workspace anew and source its install/setup.bash"
    elif not module:
        remedy = "install modules that fit each other, as docs/workspace.md says"
    return RequestError(
        f"a module {module} that {sys.executable} can import"
        if module
        else f"modules that {sys.executable} can import",
        str(error),
        remedy,
    )
