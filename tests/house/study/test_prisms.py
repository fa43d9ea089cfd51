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

"""Square prisms and dice: closed forms, published rolls, and how far each method is
from them.
"""

import math

import numpy as np
import pytest

from tests.answers import METHODS

from .programs import assert_written, study, study_json

KNOWN_RMS = {
    "csae": 0.147,
    "qse": 0.147,
    "adre": 0.081,
    "nqse": 0.099,
    "eae": 0.043,
    "meae": 0.105,
    "combined": 0.103,
}
"""Distance of estimators from Budden's dice, by another implementation, to three
digits.
"""
KNOWN_DROPPED_RMS = {0.2: 0.072, 0.5: 0.051, 0.8: 0.037}
"""That of its drops, 2 000 of each die, by restitution."""
DROPS = 300


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    drawing = tmp_path_factory.mktemp("prisms") / "prisms.svg"
    results = study_json(
        "prisms", "--drops", 50, "--dice-drops", DROPS, "--seed", 3, "-o", drawing
    )
    assert_written(drawing, "measured dice", "MEAE", "combined", "PQSE")
    return results


def test_solid_angles_and_areas_in_closed_form(results):
    """Every face is stable, so that the quasi-static estimate is the solid angle."""
    ratios = np.array(results["ratios"])
    half = 0.5
    above = 0.5 * ratios
    square = 4.0 * np.arctan(half**2 / (above * np.sqrt(above**2 + 2.0 * half**2)))
    sides = 1.0 - 2.0 * square / (4.0 * np.pi)
    for name in ("csae", "qse"):
        assert results["estimated"][name] == pytest.approx(sides, abs=1e-12)
    assert results["estimated"]["area"] == pytest.approx(
        4.0 * ratios / (4.0 * ratios + 2.0)
    )


def test_a_longer_prism_is_never_less_often_on_its_sides(results):
    assert (
        list(results["estimated"]) == list(results["dice_estimated"]) == list(METHODS)
    )
    for name in METHODS:
        assert np.all(np.diff(results["estimated"][name]) >= -1e-12), name


@pytest.mark.parametrize("method", KNOWN_RMS)
def test_estimators_are_as_far_from_the_dice_as_is_known(results, method):
    (entry,) = (misfit for misfit in results["misfits"] if misfit["method"] == method)
    assert entry["rms"] == pytest.approx(KNOWN_RMS[method], abs=0.0015)


def test_drops_are_as_far_from_the_dice_as_is_known(results):
    """Four standard deviations of the difference of two runs, and the rounding.

    An error e of a die with variance v moves the root mean square of n dice by e / (n
    rms) of its own; the dice are the same for both.
    """
    measured = np.array([entry["probability"] for entry in results["dice"]])
    for entry in results["dice_simulated"]:
        share = np.array([point["probability"] for point in entry["points"]])
        rms = math.sqrt(np.mean((share - measured) ** 2))
        variance = share * (1.0 - share) * (1.0 / DROPS + 1.0 / 2000)
        spread = math.sqrt(((share - measured) ** 2 * variance).sum()) / (
            len(share) * rms
        )
        assert rms == pytest.approx(
            KNOWN_DROPPED_RMS[entry["restitution"]], abs=4.0 * spread + 0.0005
        )
        (stated,) = (
            misfit
            for misfit in results["misfits"]
            if misfit["restitution"] == entry["restitution"]
        )
        assert stated["rms"] == pytest.approx(
            rms, abs=5e-4
        )  # dice are published to three digits


def test_the_best_come_first():
    lines = study("prisms", "--drops", 5, "--dice-drops", 5).splitlines()
    places = [
        next(k for k, line in enumerate(lines) if line.startswith(f"| {title} "))
        for title in ("PQSE", "EAE", "NQSE", "combined", "MEAE", "area")
    ]
    assert places == sorted(places)


@pytest.mark.long
def test_plates_fitted_to_some_parts_predict_the_others():
    """Of eleven plates, each one degree of freedom: 1.4 is two errors of the expected
    rms.
    """
    results = study_json("plates", "--splits", 1)
    assert results["splits"] == 1 and len(results["plates"]) == 11
    errors = [plate["errors"]["fit"] for plate in results["plates"]]
    assert (
        0.0
        < np.mean(np.square(errors))
        < np.mean(np.square([1.4 * plate["told"] for plate in results["plates"]]))
    )
