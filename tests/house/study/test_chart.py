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

"""The chart of speed against accuracy: every method is on it, and its front is one."""

import pytest

from tests.answers import METHODS
from tests.running import strict_json

from .programs import assert_written, first, reference, refused, study_json, write

TITLES = [
    "area",
    "CSAE",
    "ADRE",
    "QSE",
    "PQSE",
    "NQSE",
    "EAE",
    "MEAE",
    "combined",
    "split",
]


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return write(
        tmp_path_factory.mktemp("dataset") / "some.npz", first(reference(), 30)
    )


@pytest.fixture(scope="module")
def drawing(tmp_path_factory):
    return tmp_path_factory.mktemp("chart") / "new" / "chart_0.3.svg"


@pytest.fixture(scope="module")
def sizes(file, drawing):
    results = study_json("chart", "--dataset", file, "--quick", "-o", drawing)
    assert results == strict_json(drawing.with_suffix(".json").read_text())
    assert results["dataset"]["bodies"] == 30
    return results["sizes"]


@pytest.mark.long
class TestChart:
    def test_every_method_is_on_it_at_every_size(self, sizes):
        assert len(sizes) == 3
        for entry in sizes:
            names = {
                point["name"]
                for point in entry["points"]
                if point["kind"] in ("paper", "estimator")
            }
            assert names == set(TITLES)
            kinds = {point["kind"] for point in entry["points"]}
            assert kinds == {
                "paper",
                "estimator",
                "default",
                "hybrid",
                "simulation",
                "outside",
            }
            for point in entry["points"]:
                assert 0.0 < point["seconds"] < 600.0
                assert 0.0 <= point["low"] <= point["error"] <= point["high"] < 1.0

    def test_nobody_on_the_front_is_beaten_and_everybody_else_is(self, sizes):
        """Points whose error is lost in the noise are not drawn."""
        for entry in sizes:
            points = {
                k: point
                for k, point in enumerate(entry["points"])
                if point["error"] > 0.0
            }
            for k, point in points.items():
                beaten = any(
                    rival["seconds"] < point["seconds"]
                    and rival["error"] < point["error"]
                    for rival in points.values()
                )
                assert (k in entry["pareto_front"]) != beaten
            assert set(entry["pareto_front"]) <= set(points)

    def test_errors_are_those_of_the_table(self, sizes, file):
        (table,) = study_json("table", "--dataset", file, "--no-rerun")
        points = {point["name"]: point for point in sizes[0]["points"]}
        for entry, title in zip(table["estimators"], TITLES, strict=True):
            assert points[title]["error"] == pytest.approx(entry["pooled"]["error"])
        assert [entry["name"] for entry in table["estimators"]] == list(METHODS)

    def test_errors_of_drops_fall_with_the_root_of_their_number(self, sizes):
        for entry in sizes:
            errors = [
                point["error"]
                for point in entry["points"]
                if point["kind"] == "simulation"
            ]
            assert errors == pytest.approx(
                [errors[0] / 10.0 ** (0.5 * k) for k in range(3)]
            )

    def test_trimesh_errs_as_the_quasi_static_estimator_on_polyhedra(self, sizes):
        for entry in sizes[:2]:
            points = {point["name"]: point["error"] for point in entry["points"]}
            assert points["trimesh.poses"] == pytest.approx(points["QSE"], abs=1e-6)

    def test_the_default_answer_is_within_its_target_and_better_than_its_estimate(
        self, sizes
    ):
        """The target is kept for a part with 90 %, so by all of them together."""
        for entry in sizes:
            (answer,) = (
                point for point in entry["points"] if point["kind"] == "default"
            )
            assert answer["name"].startswith("default answer, n = ")
            assert answer["error"] < 0.02
            estimates = [
                point["error"]
                for point in entry["points"]
                if point["kind"] in ("paper", "estimator")
            ]
            assert answer["error"] < min(estimates)

    def test_it_is_drawn_with_every_name(self, sizes, drawing):
        assert_written(
            drawing,
            *TITLES,
            "trimesh.poses",
            "drop simulation",
            "hybrid",
            "default answer (auto)",
        )


@pytest.mark.parametrize("kind", ["chart", "prisms", "stability", "plates", "figures"])
def test_a_place_that_cannot_be_written_is_refused_before_anything_is_measured(
    kind, tmp_path
):
    (tmp_path / "file").write_text("")
    line = refused(kind, "-o", tmp_path / "file" / "deep" / "name.png")
    assert "name another one" in line
