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

"""Which entries of `mesh_topics` are topics, by the grammar of names in ROS."""

import pytest

from ros_pose_stats.node.settings import mesh_topics
from tests.running import refusal_of


@pytest.mark.parametrize(
    ("entry", "part_id", "topic"),
    [
        ("/cad/bracket", "bracket", "/cad/bracket"),
        ("~/mine", "mine", "~/mine"),
        ("a=b=_1/nut", "a=b", "_1/nut"),
    ],
)
def test_a_topic_has_a_part(entry, part_id, topic):
    assert mesh_topics([entry]) == {part_id: topic}


@pytest.mark.parametrize(
    "entry",
    ["/", "~", "part=", "=", "/a/", "//a", "a b", "/1a", "part=/ü", "part=~x", "a-b"],
)
def test_what_is_no_topic_is_refused_by_its_spelling(entry):
    line = refusal_of(mesh_topics, [entry])
    assert "mesh_topics as" in line and f"got '{entry}'" in line
