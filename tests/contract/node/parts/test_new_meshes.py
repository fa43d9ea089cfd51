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

"""Copies of a mesh, and new meshes under an old name."""

from itertools import pairwise

import numpy as np
import pytest
from ros_pose_stats_msgs.msg import PoseStatistics

from ..harness.cell import MeshPublisher, latched, publishers_of_parts
from ..harness.client import until
from ..harness.jobs import (
    LONG,
    cancelled,
    finished,
    known_part,
    running_with_results,
    start,
)
from ..harness.listed import recorded_of
from ..harness.parts import WEDGE, flat, library_part, nested, new_id, scaled, whole


@pytest.fixture
def publisher(cell):
    return MeshPublisher(cell).matched()


class TestCopies:
    def test_of_the_same_mesh_are_ignored(self, cell, shared_node, publisher):
        """Also of another form, in another unit, and from a latched publisher."""
        part_id = new_id()
        with cell.late_joiner() as joiner:
            publisher.publish(
                *[flat(WEDGE, part_id)] * 50,
                nested(WEDGE, part_id),
                flat(scaled(2.0), part_id, unit=0.5),
            )
            refined = until(
                lambda: (candidate := latched(cell, part_id)).drops and candidate
            )
            MeshPublisher(cell, latched=True).matched().publish(flat(WEDGE, part_id))
            repeated = cell.good(
                "estimate", part=flat(scaled(2.0), part_id, unit=0.5)
            ).statistics
            assert whole(repeated) == whole(refined)
            last = new_id()  # taken in its turn: by then all others have been
            publisher.publish(flat(WEDGE, last))
            joiner.wait(last)
            joiner.wait(part_id, lambda message: message.drops)
            assert whole(joiner.of(part_id)[-1]) == whole(refined)
            assert {message.part_digest for message in joiner.of(part_id)} == {
                refined.part_digest
            }
        assert len(recorded_of(shared_node, "part_mesh", part_id)) == 1


class TestNewMeshes:
    def test_twenty_under_one_name_beside_other_parts(
        self, cell, shared_node, publisher
    ):
        """The last one wins, numbers rise, and late joiners get every part's own."""
        factors = {new_id(): 1.0 + 0.01 * number for number in range(8)}
        publisher.publish(
            *[flat(scaled(factor), part_id) for part_id, factor in factors.items()]
        )
        for part_id in factors:
            latched(cell, part_id)
        swapped = next(iter(factors))
        factors[swapped] = 2.5
        end = library_part(scaled(2.5)).digest
        with cell.late_joiner() as joiner:
            joiner.wait(swapped)
            publisher.publish(
                *[flat(scaled(factor), swapped) for factor in np.linspace(2.0, 2.5, 20)]
            )
            joiner.wait(swapped, lambda message: message.part_digest == end)
            results = joiner.of(swapped)
        recorded = recorded_of(shared_node, "pose_statistics", swapped)
        assert len({message.part_digest for message in recorded}) == 21
        assert all(
            b.revision > a.revision
            for a, b in (*pairwise(results), *pairwise(recorded))
        )
        with cell.late_joiner() as joiner:
            for part_id, factor in factors.items():
                assert (
                    joiner.wait(part_id).part_digest
                    == library_part(scaled(factor)).digest
                )

    def test_late_joiners_need_no_more_room_than_there_are_parts(self, tuned):
        parts = {known_part(tuned) for _ in range(3)}
        for factor in (2.0, 4.0):
            for part_id in parts:
                tuned.good("estimate", part=flat(scaled(factor), part_id))
        # The farewell of a part just forgotten is latched for a moment, and takes room.
        until(lambda: publishers_of_parts(tuned) == len(parts), "a publisher each")
        heard = {}

        def take(message):
            heard[message.part_id] = message.part_digest

        subscription = tuned.subscribe(
            PoseStatistics,
            f"{tuned.prefix}/pose_statistics",
            take,
            latched=True,
            depth=len(parts),
        )
        until(lambda: heard.keys() == parts, "all parts")
        tuned.node.destroy_subscription(subscription)
        assert set(heard.values()) == {library_part(scaled(4.0)).digest}

    def test_back_to_an_earlier_mesh_its_best_result_counts_again(
        self, cell, shared_node
    ):
        part_id = known_part(cell)
        finished(cell, start(cell, part_id, 3000))
        best = latched(cell, part_id)
        for factor in (2.0, 1.0, 2.0):
            interim = cell.good(
                "estimate", part=flat(scaled(factor), part_id)
            ).statistics
        assert not interim.job_id
        assert interim.part_digest != best.part_digest
        cell.good("estimate", part=flat(WEDGE, part_id))
        latched_statistics = latched(cell, part_id)
        assert (
            latched_statistics.part_digest,
            latched_statistics.drops,
            latched_statistics.header.stamp,
        ) == (
            best.part_digest,
            3000,
            best.header.stamp,
        )
        assert latched_statistics.revision > interim.revision > best.revision
        assert len(recorded_of(shared_node, "part_mesh", part_id)) == 2  # each once

    def test_a_job_on_the_old_mesh_is_not_latched_for_the_new(self, cell):
        part_id = known_part(cell)
        job_id = start(cell, part_id, LONG, seed=3)
        running_with_results(cell, job_id)
        cell.good("estimate", part=flat(scaled(1.5), part_id))
        answer = cancelled(cell, job_id).statistics
        latched_statistics = latched(cell, part_id)
        assert answer.drops > 0 and answer.part_digest != latched_statistics.part_digest
        assert not latched_statistics.job_id
