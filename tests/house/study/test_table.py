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

"""Table I: the paper's figures at a named shift, another implementation's, and known
errors.
"""

import math
from functools import cache

import numpy as np
import pytest

from ros_pose_stats import estimate
from tests.answers import METHODS

from .programs import drawn, first, reference, refused, study, study_json, write

PAPER = {
    "area": 0.112,
    "csae": 0.085,
    "adre": 0.078,
    "qse": 0.070,
    "pqse": 0.072,
    "nqse": 0.062,
    "eae": 0.068,
    "meae": 0.040,
    "combined": 0.036,
}
"""Table I of the paper."""
TIED = ({"nqse", "eae"}, {"pqse", "qse"})
"""Pairs that lie within their errors on the bodies here; the paper has them 0.6 and 0.2
apart.
"""

OTHER = {
    (0.0, "inertia"): {
        "area": 10.7,
        "csae": 8.7,
        "adre": 7.7,
        "qse": 7.4,
        "nqse": 6.5,
        "eae": 6.4,
        "meae": 3.1,
        "combined": 3.0,
        "sensitivity": 4.3,
        "noise": 3.14,
    },
    (0.25, "inertia"): {
        "area": 13.4,
        "csae": 10.3,
        "adre": 8.8,
        "qse": 8.7,
        "nqse": 7.8,
        "eae": 8.4,
        "meae": 3.9,
        "combined": 3.7,
        "sensitivity": 5.8,
        "noise": 3.07,
    },
    (0.65, "second"): {
        "area": 15.1,
        "csae": 11.3,
        "adre": 9.1,
        "qse": 9.8,
        "nqse": 8.7,
        "eae": 8.9,
        "meae": 4.0,
        "combined": 3.9,
        "sensitivity": 6.4,
        "noise": 3.13,
    },
    (1.0, "inertia"): {
        "area": 27.0,
        "csae": 15.7,
        "adre": 10.3,
        "qse": 14.5,
        "nqse": 14.2,
        "eae": 9.1,
        "meae": 5.2,
        "combined": 5.4,
        "sensitivity": 8.0,
        "noise": 2.65,
    },
}
"""Points, of another implementation with 1 057 bodies of its own and 100 drops of
each.
"""
SIGMAS = 3.5
"""Of some 60 figures one is further off by chance once in 40 times."""

UNSHIFTED = (0.0, "inertia")


@cache
def table(shift, moment):
    (results,) = study_json(
        "table", "--shift", shift, "--shift-moment", moment, "--no-rerun"
    )
    return results


def by_name(results):
    return {entry["name"]: entry for entry in results["estimators"]}


def errors(results):
    return {name: entry["pooled"]["error"] for name, entry in by_name(results).items()}


@pytest.mark.long
class TestPaper:
    def test_its_errors_and_order_of_the_estimators_come_out_without_shift(self):
        results = errors(table(*UNSHIFTED))
        for name in PAPER.keys() - {"area"}:
            assert results[name] == pytest.approx(PAPER[name], abs=0.01), name
        order = sorted(PAPER, key=PAPER.get)
        turned = [
            {better, worse}
            for k, better in enumerate(order)
            for worse in order[k + 1 :]
            if results[worse] <= results[better]
        ]
        assert all(pair in TIED for pair in turned)

    @pytest.mark.parametrize(
        "key",
        [
            UNSHIFTED,
            pytest.param((0.25, "inertia"), marks=pytest.mark.long),
            (0.65, "second"),
            pytest.param((1.0, "inertia"), marks=pytest.mark.long),
        ],
        ids=str,
    )
    def test_another_implementation_has_the_same_figures(self, key):
        results = table(*key)
        reference = OTHER[key]
        # Its drops are as few as the first hundred, its bodies others.
        pairs = {
            "sensitivity": [results["sensitivity"]] * 2,
            "noise": [results["pooled_noise_of_100"]] * 2,
            **{
                name: (entry["pooled"], entry["pooled_of_first"])
                for name, entry in by_name(results).items()
            },
        }
        for name, value in reference.items():
            error = math.hypot(*(entry["standard_error"] for entry in pairs[name]))
            assert 100 * pairs[name][0]["error"] == pytest.approx(
                value, abs=100 * SIGMAS * error + 0.05
            ), name

    def test_split_and_drops_beside_it_beat_the_paper_s_best(self):
        """On bodies that no fit has seen."""
        for key in (UNSHIFTED, (0.65, "second")):
            results = errors(table(*key))
            assert results["split"] < 0.8 * min(results["combined"], results["meae"])
        # Together they are better than either, though the estimate is doubted.
        results = table(*UNSHIFTED)
        assert results["combined"]["pooled"]["error"] < min(
            errors(results)["split"], results["pooled_noise_of_100"]["error"]
        )


NUMBER = 100
"""Bodies whose counts are drawn from known probabilities."""


@pytest.fixture(scope="module")
def bodies():
    return first(reference(), NUMBER)


@pytest.fixture(scope="module")
def probability(bodies):
    """What three estimators say of each pose, in the order of the file."""
    stated = {name: [] for name in ("csae", "nqse", "meae")}
    for part in bodies.parts():
        for name, column in stated.items():
            poses = estimate(part, name, cluster_tolerance=0.0, round_sides=0).poses
            column += [
                pose.probability for pose in sorted(poses, key=lambda pose: pose.index)
            ]
    return {name: np.array(column) for name, column in stated.items()}


def normed(bodies, values):
    return values / np.bincount(bodies.body, values)[bodies.body]


def analysed(file):
    (results,) = study_json("table", "--dataset", file, "--no-rerun")
    return results


class TestKnownErrors:
    """The metric must find the error that was put in, whatever the noise of the
    drops.
    """

    def test_an_error_as_large_as_the_noise_is_recovered(
        self, bodies, probability, tmp_path
    ):
        truth = normed(bodies, 0.6 * probability["meae"] + 0.4 * probability["csae"])
        results = analysed(drawn(tmp_path / "a.npz", bodies, truth, 3, drops=200))
        for name in ("meae", "csae"):
            true_error = math.sqrt(np.mean((truth - probability[name]) ** 2))
            row = by_name(results)[name]
            for entry in (
                row["pooled"],
                row["pooled_of_first"],
                *row["by_restitution"].values(),
            ):
                assert entry["error"] == pytest.approx(
                    true_error, abs=4 * entry["standard_error"]
                )
                assert entry["deviation"] ** 2 == pytest.approx(
                    entry["error"] ** 2 + entry["noise"] ** 2
                )
        row = by_name(results)["meae"]["pooled_of_first"]
        assert row["deviation"] - row["error"] > 4 * row["standard_error"]
        true_error = math.sqrt(np.mean(truth * (1 - truth)) / 100)
        noise = results["pooled_noise_of_100"]["error"]
        assert noise == pytest.approx(true_error, rel=0.042)  # of 300 bodies' drops
        assert results["sensitivity"]["low"] == 0.0  # the same at every restitution
        assert results["sensitivity"]["error"] < 0.01

    def test_an_exact_estimator_has_none(self, bodies, probability, tmp_path):
        results = analysed(drawn(tmp_path / "b.npz", bodies, probability["meae"], 5))
        assert by_name(results)["meae"]["pooled"]["low"] == 0.0
        assert by_name(results)["csae"]["pooled"]["low"] > 0.03


class TestWhatItPrints:
    @pytest.mark.parametrize(("number", "drops"), [(1, 100), (2, 50), (21, 2)])
    def test_few_bodies_or_drops_give_strict_numbers(
        self, bodies, tmp_path, number, drops
    ):
        few_bodies = first(bodies, number)
        even = 1.0 / few_bodies.arrays["poses"][few_bodies.body]
        file = drawn(tmp_path / "a.npz", few_bodies, even, 1, drops=drops)
        results = analysed(file)
        assert [entry["name"] for entry in results["estimators"]] == list(METHODS)
        assert (results["estimators"][0]["pooled"]["standard_error"] is None) == (
            number == 1
        )
        assert "nan" not in study("table", "--dataset", file, "--no-rerun")

    def test_the_text_names_the_shift_and_sets_the_paper_beside(self, bodies, tmp_path):
        file = write(tmp_path / "a.npz", first(bodies, 30))
        text = study("table", "--dataset", file, file, "--no-rerun")
        assert text.startswith("### Shift 0 (inertia), 30 bodies, 1000 drops of each")
        row, second_row = (
            line for line in text.splitlines() if line.startswith("| MEAE ")
        )
        assert row == second_row
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        assert cells[1] == "4.0"
        assert cells[2].startswith(f"{100 * errors(analysed(file))['meae']:.2f} ±")

    def test_the_largest_deviations_are_dropped_again(self, bodies, tmp_path):
        file = write(tmp_path / "a.npz", first(bodies, 3))
        (results,) = study_json("table", "--dataset", file)
        assert len(results["outliers"]) == 3
        assert len({entry["body"] for entry in results["outliers"]}) == 3


class TestRefusals:
    def test_a_shift_without_a_reference_dataset_names_those_there_are(self):
        line = refused("table", "--shift", "0.5")
        assert (
            "0.65 (second)" in line
            and "got 0.5 (inertia)" in line
            and "--dataset" in line
        )
        assert "--shift beside" in refused("table", "--shift-moment", "second")

    def test_files_that_cannot_be_compared(self, bodies, tmp_path):
        """Missing, of another kind or version, contradicting themselves; or too few
        drops.
        """
        two_bodies = first(bodies, 2)
        even = 1.0 / two_bodies.arrays["poses"][two_bodies.body]
        (tmp_path / "text.npz").write_text("no archive")
        count = two_bodies.arrays["count"].copy()
        center = two_bodies.arrays["center_of_mass"] + 0.01
        count[0, 0, 0] += 1
        newer = two_bodies._replace(schema={**two_bodies.schema, "format_version": 99})
        for file, words in (
            (tmp_path / "nothing.npz", "nothing.npz"),
            (tmp_path / "text.npz", "anew"),
            (write(tmp_path / "a.npz", two_bodies, count=count), "add up"),
            (write(tmp_path / "b.npz", two_bodies, vertex=None), "vertex"),
            (write(tmp_path / "c.npz", newer), "version 99"),
            (
                drawn(tmp_path / "e.npz", two_bodies, even, 1, drops=1),
                "2 settled drops",
            ),
            (
                write(tmp_path / "d.npz", two_bodies, center_of_mass=center),
                "stable poses",
            ),
        ):
            assert words in refused("table", "--dataset", file, "--no-rerun"), words

    @pytest.mark.parametrize(
        "words",
        [
            (),
            ("speed",),
            ("table", "--shift", "much"),
            ("prisms", "--drops", "0"),
            ("chart", "-o", "folder/"),
        ],
    )
    def test_words_that_mean_nothing(self, words):
        assert refused(*words)
