"""The parts that the node knows, and which result of a part is shown; without a node."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ros_pose_stats_msgs.msg import PoseStatistics

from ros_pose_stats.errors import RequestError
from ros_pose_stats.ros.parts.catalogue import Catalogue, KnownPart
from ros_pose_stats.ros.parts.latching import replaces


def known(name):
    return KnownPart(SimpleNamespace(part_id=name), b"", (-1.0, -1.0))


@pytest.fixture
def forgotten():
    return []


@pytest.fixture
def catalogue(forgotten):
    return Catalogue(lambda one: forgotten.append(one.part.part_id))


def names(catalogue):
    return [one.part.part_id for one in catalogue.all()]


class TestCatalogue:
    def test_the_least_recently_used_makes_room(self, catalogue, forgotten):
        for name in "abc":
            catalogue.put(known(name), 3)
        catalogue.find("a")
        catalogue.current("b")  # does not count
        catalogue.put(known("d"), 3)
        assert (names(catalogue), forgotten) == (["c", "a", "d"], ["b"])

    def test_the_same_name_takes_its_place(self, catalogue, forgotten):
        first, second = known("a"), known("a")
        catalogue.put(first, 2)
        catalogue.put(known("b"), 2)
        catalogue.put(second, 2)
        assert catalogue.known("a") is second and forgotten == []

    def test_forget(self, catalogue, forgotten):
        catalogue.put(known("a"), 2)
        catalogue.forget("a")
        assert (names(catalogue), forgotten) == ([], ["a"])
        with pytest.raises(RequestError, match="'a'"):
            catalogue.forget("a")

    def test_a_refusal_names_some_that_are_known(self, catalogue):
        for number in range(100):
            catalogue.put(known(f"part_{number:02d}"), 200)
        with pytest.raises(RequestError, match=r"part_00, .*, part_07, …\)"):
            catalogue.known("nobody")

    @given(st.lists(st.tuples(st.sampled_from("pfc"), st.sampled_from("abcdefgh")),
                    max_size=40), st.integers(1, 5))
    def test_is_a_list_with_the_last_used_at_the_end(self, steps, most):
        model, gone = [], []
        catalogue = Catalogue(lambda one: gone.append(one.part.part_id))
        for step, name in steps:
            if step == "p":
                catalogue.put(known(name), most)
            elif step == "f":
                catalogue.find(name)
            else:
                catalogue.current(name)
            if step == "p" or (step == "f" and name in model):
                model = [one for one in model if one != name] + [name]
            model = model[-most:]
        assert names(catalogue) == model


def result(error, drops=0, **fields):
    return PoseStatistics(expected_error=error, plate_error=0.05, drops=drops,
                          **{"part_digest": "digest", "final": True, **fields})


class TestReplaces:
    @pytest.mark.parametrize(("new", "old", "wanted"), [
        (0.01, 0.02, True), (0.02, 0.01, False), (0.01, 0.01, True),
        (0.06, math.nan, False), (0.04, math.nan, True), (math.nan, 0.04, False),
        (math.nan, 0.06, True), (math.nan, math.nan, True)])
    def test_a_larger_error_never_replaces_a_smaller_one(self, new, old, wanted):
        assert replaces(result(new), result(old)) is wanted

    def test_an_estimate_by_the_method_wanted_now_takes_the_place_of_another(self):
        old = result(0.01, method="combined")
        assert replaces(result(0.1, method="csae"), old)
        assert not replaces(result(0.1, method="combined"), old)
        assert not replaces(result(0.1, method="csae"), result(0.01, 100, method="simulation"))

    def test_drops_with_an_estimate_count_like_drops(self):
        estimated, together = result(0.02, method="split"), result(0.01, 100, method="hybrid")
        assert replaces(together, estimated) and not replaces(estimated, together)
        assert not replaces(result(0.03, 100, method="hybrid"), estimated)
        assert not replaces(result(0.02, 200, method="simulation"), together)
        assert replaces(result(0.005, 900, method="simulation"), together)

    def test_another_digest_is_another_part(self):
        assert replaces(result(0.5, part_digest="other"), result(0.01))

    def test_the_end_of_a_simulation_takes_the_place_of_what_it_showed_before(self):
        """With few drops the last ones may raise the error a little; it must end all the same."""
        before = result(0.0200, 95, job_id="job", final=False)
        assert replaces(result(0.0203, 100, job_id="job"), before)
        assert not replaces(result(0.0203, 100, job_id="other"), before)
        assert not replaces(result(0.0203, 98, job_id="job", final=False), before)
