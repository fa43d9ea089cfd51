"""The library's front door: the names of the contract and how they are called."""

from __future__ import annotations

import ast
import importlib
import math
import pickle

import numpy as np
import pytest

import ros_pose_stats
from ros_pose_stats import errors, shapes
from tests.bodies import METHODS, write_stl
from tests.running import ROOT


def test_names_of_the_contract():
    from ros_pose_stats import estimate, load_part, part_from_mesh

    assert callable(load_part)
    assert callable(part_from_mesh)
    assert callable(estimate)


def test_every_public_name_exists_and_is_what_its_module_has():
    for name, home in ros_pose_stats._HOMES.items():
        module = importlib.import_module(f"ros_pose_stats.{home}")
        assert getattr(ros_pose_stats, name) is getattr(module, name)
    assert set(ros_pose_stats.__all__) == {*ros_pose_stats._HOMES, "__version__"}


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'estimator_of_everything'"):
        ros_pose_stats.estimator_of_everything  # noqa: B018


def test_the_examples_of_the_contract(tmp_path):
    file = write_stl(tmp_path / "clamp.stl", shapes.box(20.0, 30.0, 40.0))
    part = ros_pose_stats.load_part(file, unit="mm")
    found = ros_pose_stats.estimate(part, method="combined", restitution=0.3, drop_height=0.5,
                                    cluster_tolerance=0.01)
    assert 0.0 < found.poses[0].probability < 1.0
    assert isinstance(found.poses[0].down, np.ndarray)
    vertices, triangles = shapes.box(0.02, 0.03, 0.04)
    other = ros_pose_stats.part_from_mesh(vertices, triangles, center_of_mass=(0.001, 0.0, 0.0),
                                          mass=0.2, inertia=np.diag((2e-5, 2e-5, 2e-5)))
    assert other.center_of_mass.tolist() == [0.001, 0.0, 0.0]


class TestEstimate:
    part = ros_pose_stats.part_from_mesh(*shapes.box(0.02, 0.03, 0.04))

    def test_defaults(self):
        found, auto = ros_pose_stats.estimate(self.part), ros_pose_stats.auto(self.part)
        assert (found.method, found.choice) == (auto.method, auto.choice) == (
            "split", found.choice)
        assert "most accurate" in found.choice
        assert found.restitution == 0.5
        assert found.cluster_tolerance == 0.0025
        assert found.drop_height == 20.0 * found.radius
        assert 0.0 < found.expected_error < 0.1
        assert found.plate_error == 0.05
        assert (found.drops, found.unsettled, found.seed) == (0, 0, 0)
        assert found.warnings == ()
        assert found.version == ros_pose_stats.__version__
        assert found.part_digest == self.part.digest
        assert 0.0 < found.seconds < 60.0

    @pytest.mark.parametrize("method", sorted(set(METHODS) - {"split"}))
    def test_methods_ignore_what_they_are_blind_to(self, method):
        plain = ros_pose_stats.estimate(self.part, method)
        other = ros_pose_stats.estimate(self.part, method, restitution=0.9, drop_height=3.0)
        assert [pose.probability for pose in other.poses] == [
            pose.probability for pose in plain.poses]
        assert np.isnan(other.drop_height)

    def test_low_drops_are_warned_about(self):
        found = ros_pose_stats.estimate(self.part, "combined", drop_height=4.9 * 0.0269)
        (warning,) = found.warnings
        assert warning.startswith("LOW_DROP: ")
        for method, radii in (("combined", 5.1), ("split", 1.2)):
            high = ros_pose_stats.estimate(self.part, method, drop_height=radii * 0.0270)
            assert high.warnings == ()

    @pytest.mark.parametrize("radii", [1e-6, 0.4, 1.0, 4.99, 5.0, 20.0])
    def test_every_method_blind_to_the_height_says_so_from_touching_up(self, radii):
        radius = ros_pose_stats.estimate(self.part).radius
        for one in ros_pose_stats.estimate_all(self.part, drop_height=radii * radius):
            told = [line for line in one.warnings if line.startswith("LOW_DROP: ")]
            assert len(told) == (radii < 5.0 and one.method != "split"), one.method
            assert one.as_dict()["warnings"] == list(one.warnings)
            assert math.isnan(one.drop_height) == (one.method != "split")

    def test_a_method_that_knows_the_height_tells_of_a_larger_error_below_two_radii(self):
        radius = ros_pose_stats.estimate(self.part).radius
        low, high = (ros_pose_stats.estimate(self.part, drop_height=radii * radius)
                     for radii in (0.5, 20.0))
        assert low.expected_error > high.expected_error
        assert low.largest_error > high.largest_error > high.expected_error

    @pytest.mark.parametrize("method", ["", "MEAE", "simulation", None])
    def test_unknown_methods_are_refused(self, method):
        with pytest.raises(errors.RequestError, match=r"a method out of area, csae, .*combined"):
            ros_pose_stats.estimate(self.part, method)

    @pytest.mark.parametrize("options", [
        {"restitution": 1.0}, {"restitution": -0.01}, {"restitution": float("nan")},
        {"drop_height": 0.0}, {"drop_height": float("inf")}, {"drop_height": float("nan")},
        {"cluster_tolerance": -1e-9}, {"cluster_tolerance": 1.0},
        {"cluster_tolerance": float("nan")},
    ])
    def test_options_out_of_range_are_refused(self, options):
        with pytest.raises(errors.RequestError, match=r"expected a .*, got .*; "):
            ros_pose_stats.estimate(self.part, **options)


@pytest.mark.parametrize("kind", [errors.PoseStatsError, errors.MeshError, errors.RequestError,
                                  errors.MassPropertiesError, errors.MeshFileError])
def test_errors_tell_facts_and_survive_pickling(kind):
    error = kind("one thing", "another", "try again")
    assert isinstance(error, ValueError)
    assert str(error) == "expected one thing, got another; try again"
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is kind
    assert (again.expected, again.found, again.remedy) == ("one thing", "another", "try again")


@pytest.mark.parametrize("file", [
    *(ROOT / ".ci").glob("*.py"), *(ROOT / "launch").glob("*.py")], ids=lambda file: file.name)
def test_scripts_outside_the_package_import_what_is_there(file):
    imports = [one for one in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
               if isinstance(one, ast.ImportFrom) and one.module.startswith("ros_pose_stats.")]
    for one in imports:
        module = importlib.import_module(one.module)
        assert all(hasattr(module, name.name) for name in one.names), ast.unparse(one)
