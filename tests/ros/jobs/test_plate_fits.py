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
