"""A node that fits its plate: counts in, a profile in the file, results of that scene out."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from types import SimpleNamespace

import numpy as np
import pytest
from ros_pose_stats_msgs.msg import PoseCounts
from ros_pose_stats_msgs.srv import FitPlate

from ros_pose_stats import plates, shapes, simulate
from ros_pose_stats.errors import RequestError
from ros_pose_stats.recording.analysis.numbering import Numbering
from ros_pose_stats.ros.jobs import plate_fits
from ros_pose_stats.ros.jobs.plate_fits import PlateFits, choose_counts, counts_on
from ros_pose_stats.ros.parts.cell_counts import CellCounts, Ground
from ros_pose_stats.ros.settings import settings_of

from ..harness.cell import MeshPublisher, cell_of, latched
from ..harness.client import until
from ..harness.parts import flat, library_part

BOXES = {"flat": shapes.box(0.020, 0.016, 0.012), "bar": shapes.box(0.030, 0.010, 0.020)}
TRUTH = 0.25, 0.12
"""Restitution and drop height of the plate that is counted on."""


def counts_of(model, surface, parts, seed):
    """What a camera counts of a part on the true plate."""
    seen = simulate(library_part(surface), parts, TRUTH[0], seed, TRUTH[1], workers=1)
    return PoseCounts(
        part_id=model.part_id, part_digest=model.part_digest, plate=model.plate,
        cluster_tolerance=model.cluster_tolerance, round_sides=model.round_sides,
        index=[pose.index for pose in seen.poses], count=[pose.count for pose in seen.poses])


def count_boxes(client, parts):
    """Publish meshes and counts; wait until the node has learnt from them."""
    camera = MeshPublisher(client, f"{client.prefix}/pose_counts", PoseCounts).matched()
    for seed, (name, surface) in enumerate(BOXES.items(), start=1):
        model = client.good("estimate", part=flat(surface, name)).statistics
        camera.publish(counts_of(model, surface, parts, seed))
    for name in BOXES:
        until(lambda name=name: latched(client, name).observed == parts, f"counts of {name}")


@pytest.mark.long
def test_a_plate_is_learnt_written_used_and_there_after_a_restart(domain, tmp_path):
    file = tmp_path / "plates.yaml"
    parameters = {"plates": str(file), "max_job_seconds": 10_000.0}
    with cell_of(domain, tmp_path / "bags", "fitting", **parameters) as (node, client):
        assert "none" in client.refused("fit_plate")
        count_boxes(client, 400)
        assert "a plate's name" in client.refused("fit_plate", apply=True)
        fit = client.send("fit_plate", plate="glass", apply=True)
        before = latched(client, "bar")
        assert (before.restitution, before.plate) == (0.5, "")  # asked for while it fits
        assert "one fit at a time" in client.refused("fit_plate", plate="glass")
        until(fit.done, "the fit")
        answer = fit.result()
        assert answer.success, answer.message
        assert answer.restitution_low <= TRUTH[0] <= answer.restitution_high
        assert answer.drop_height_low <= TRUTH[1] <= answer.drop_height_high
        assert (answer.counted, sorted(answer.parts)) == (800, sorted(BOXES))
        check_profile(plates.read_profiles(file)["glass"], answer)
        for name in BOXES:
            found = until(lambda name=name: applied(client, name), f"{name} on the plate")
            assert found.revision > before.revision or name != "bar"
            check_result(found, answer, 400)
        model = client.good("estimate", part_id="bar").statistics
        assert model.plate_error == answer.plate_error
        node.assert_sound()
    with cell_of(domain, tmp_path / "bags", "fitting", plate="glass", **parameters) as (
            node, client):
        for name in BOXES:
            check_result(applied(client, name), answer, 400)
        assert client.good("estimate", part_id="bar").statistics.plate_error == answer.plate_error
        assert "plate to be one of" in client.set(plate="oak")["plate"]
        assert client.set(plates="", restitution=0.6) == {}
        until(lambda: latched(client, "bar").restitution == 0.6, "the node's own scene")
        assert client.good("estimate", part_id="bar").statistics.plate_error == 0.05
        assert "parameter plates" in client.refused("fit_plate", apply=True)
        node.assert_sound()


def applied(client, name):
    """What is latched, once it is of the fitted plate."""
    found = latched(client, name)
    return found if found.plate == "glass" else None


def check_profile(profile, answer):
    told = [getattr(answer, name + end) for name in ("restitution", "drop_height")
            for end in ("", "_low", "_high")]
    kept = [getattr(profile, name + end) for name in ("restitution", "drop_height")
            for end in ("", "_low", "_high")]
    assert kept == told
    assert (profile.plate_error, profile.p_value) == (answer.plate_error, answer.p_value)
    assert (profile.counted, list(profile.parts)) == (answer.counted, list(answer.parts))


def check_result(found, answer, observed):
    """Of the fitted scene, and surer than its plate alone makes it."""
    assert (found.restitution, found.drop_height) == (answer.restitution, answer.drop_height)
    assert (found.method, found.observed) == ("observed", observed)
    assert found.plate_error < answer.plate_error


def known_counted(name, total, plate="glass", surface=BOXES["flat"]):
    """A known part, as far as fits look at it."""
    counts = CellCounts(Ground(Numbering(0.0025, 192), plate), np.array(total))
    return SimpleNamespace(part=library_part(surface), counts=counts, name=name,
                           revisions=SimpleNamespace(lock=threading.RLock()))


@pytest.mark.parametrize(("sides", "plate", "goes_on"), [
    (48, "glass", True), (192, "glass", True), (48, "steel", False)])
def test_counts_go_on_where_a_plate_brings_its_round_sides(sides, plate, goes_on):
    drum = library_part(shapes.prism(64, 0.01, 0.02))
    ground = Ground(Numbering(0.0025, 192), "glass")
    assert ground.goes_on_as(Ground(Numbering(0.0025, sides), plate), drum) == goes_on


def test_counts_end_where_round_sides_number_the_poses_anew():
    facets = library_part(shapes.prism(64, 0.01, 0.02))
    assert not Ground(Numbering(0.0, 192), "glass").goes_on_as(
        Ground(Numbering(0.0, 48), "glass"), facets)


class TestWhatIsFitted:
    PARTS = (known_counted("glass", [3, 0, 2, 0, 1, 0]), known_counted("nothing", [0] * 6),
             known_counted("steel", [9] * 6, "steel"), known_counted("unnamed", [5] * 6, ""),
             SimpleNamespace(counts=None))

    @pytest.mark.parametrize(("plate", "present", "names"), [
        ("glass", "glass", ["glass"]), ("steel", "glass", ["steel"]), ("", "", ["unnamed"]),
        ("glass", "", ["glass", "unnamed"]), ("new", "", ["unnamed"])])
    def test_counts_of_the_plate(self, plate, present, names):
        found = counts_on(plate, present, self.PARTS)
        assert [known.name for known, _ in found] == names

    @pytest.mark.parametrize(("parts", "said"), [
        (PARTS, "on plate 'oak', got only those on '', 'glass', 'steel'"),
        (PARTS[1:2], "on plate 'oak', got none")])
    def test_none_of_it(self, parts, said):
        with pytest.raises(RequestError, match=said):
            counts_on("oak", "glass", parts)

    def test_the_most_counted_parts_as_far_as_there_is_room(self, monkeypatch):
        counted = [plates.count_part(library_part(surface), {0: number})
                   for surface, number in zip(BOXES.values(), (5, 9), strict=True)]
        assert choose_counts(counted) == counted[::-1]
        monkeypatch.setattr(plate_fits, "MOST_GROUPS", 5)  # a box has three groups of two faces
        assert choose_counts(counted) == counted[1:]
        monkeypatch.setattr(plate_fits, "MOST_GROUPS", 2)
        with pytest.raises(RequestError, match="at most 2 groups of poses"):
            choose_counts(counted)


class FakeNode:
    """Takes the service, and keeps what is logged."""

    def __init__(self):
        self.errors = []

    def get_logger(self):
        return SimpleNamespace(info=lambda line: None, error=self.errors.append)

    def create_service(self, *_, **__):
        """Nobody calls it here."""


class TestEnds:
    """Of fits, without ROS."""

    @staticmethod
    def asked(total, plates_file="", **changes):
        node = FakeNode()
        settings = settings_of({"plates": plates_file, "workers": 1, **changes})
        fits = PlateFits(node, lambda: settings, SimpleNamespace(
            all=lambda: [known_counted("one", total, "")]), lambda plate: None)
        answer = fits.answer(FitPlate.Request(plate="glass", apply=bool(plates_file)),
                             FitPlate.Response())
        return node, fits, answer

    def refused(self, total, **changes):
        node, fits, answer = self.asked(total, **changes)
        assert isinstance(answer, Future)
        response = answer.result(timeout=120.0)
        assert not response.success and "\n" not in response.message and not node.errors
        return fits, response.message

    def test_too_few_counts_are_refused_with_what_is_missing(self):
        fits, message = self.refused([1, 2, 3, 4, 5, 6])
        assert "got 21; count 29 more" in message
        again = fits.answer(FitPlate.Request(plate="glass"), FitPlate.Response())
        assert "got 21" in again.result(timeout=120.0).message  # the first one is out of the way

    def test_time_that_is_too_short(self):
        _, message = self.refused([100] * 6, max_job_seconds=0.001)
        assert "expected a fit within 0.001 s (parameter max_job_seconds)" in message

    def test_the_end_of_the_node_gives_it_up(self):
        _, fits, answer = self.asked([100] * 6)
        assert fits.close(120.0)
        assert "expected a running node" in answer.result(timeout=0.0).message
        late = fits.answer(FitPlate.Request(plate="glass"), FitPlate.Response())
        assert "expected a running node" in late.message

    def test_a_file_that_cannot_be_written(self, tmp_path, monkeypatch):
        (tmp_path / "a file").touch()
        monkeypatch.setattr(PlateFits, "_fit", lambda *_: plates.PlateFit(
            (0.3, 0.2, 0.4), (0.1, 0.05, 0.2), 0.02, 0.5, 600, (),
            (96, 48, 192)))
        _, _, answer = self.asked([100] * 6, str(tmp_path / "a file" / "plates.yaml"), plate="")
        response = answer.result(timeout=120.0)
        assert not response.success and "can be written (parameter plates)" in response.message
        assert (response.round_sides, response.round_sides_low,
                response.round_sides_high) == (96, 48, 192)
        assert (response.restitution, response.counted) == (0.3, 600)  # found all the same
