"""The table of methods, and that library, command and node take their names from it."""

from __future__ import annotations

import inspect
from importlib import import_module

import numpy as np
import pytest

from ros_pose_stats import cli, estimate, part_from_mesh, resting_poses, shapes
from ros_pose_stats.commands.outlines import outline_command
from ros_pose_stats.estimators import ESTIMATORS, registry
from ros_pose_stats.methods import AT_ONCE, DEFAULT_METHOD, METHODS, Method
from ros_pose_stats.ros.settings import BY_NAME
from tests import bodies


def test_the_names_of_the_contract():
    assert tuple(ESTIMATORS) == bodies.METHODS
    assert (*bodies.METHODS, "auto") == AT_ONCE
    assert [one.name for one in METHODS] == [*bodies.METHODS, "hybrid", "auto", "simulation"]


def test_there_is_one_default():
    (command,) = [one for one in outline_command(cli.parser()).commands
                  if one.words[-1] == "estimate"]
    (choice,) = [one for one in command.arguments if "--method" in one.flags]
    assert choice.choices == (*bodies.METHODS, "hybrid", "auto", "all")
    assert f"(default: {DEFAULT_METHOD})" in choice.about
    assert inspect.signature(estimate).parameters["method"].default == DEFAULT_METHOD == "auto"
    assert BY_NAME["default_method"].default == DEFAULT_METHOD


@pytest.mark.parametrize("method", [one for one in METHODS if one.module],
                         ids=lambda one: one.name)
def test_a_module_has_the_function_of_the_name(method):
    function = getattr(import_module(f"ros_pose_stats.estimators.{method.module}"), method.name)
    assert len(inspect.signature(function).parameters) == (2 if method.knows_scene else 1)
    assert function.__doc__


def test_an_estimator_is_added_by_its_function_and_one_row(monkeypatch):
    """Its expected error is unknown until it is fitted; all else follows from the row."""
    def even(resting):
        return np.full(len(resting.poses), 1.0 / len(resting.poses))

    row = Method("even", "even", "as many parts in each pose", "", "solid_angles")
    monkeypatch.setattr(import_module("ros_pose_stats.estimators.solid_angles"), "even", even,
                        raising=False)
    monkeypatch.setitem(registry.ESTIMATORS, row.name, registry.bind_function(row))
    part = part_from_mesh(*shapes.box(1.0, 2.0, 3.0))
    found = estimate(part, "even")
    assert [pose.probability for pose in found.poses] == [1.0 / 6.0] * 6
    assert np.isnan(found.expected_error) and np.isnan(found.drop_height)
    assert len(resting_poses(part).poses) == 6
