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

"""The RViz configuration and the Foxglove layout name what there is."""

import json
import re
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
NODE = {"/pose_stats/markers", "/pose_stats/pose_statistics", "/diagnostics"}
BODY = "/drop/markers"
DROP = {BODY, "/drop/energy", "/drop/within_reach"}


def test_rviz_shows_topics_of_the_node_and_of_a_drop_in_the_plate_frame():
    config = yaml.safe_load(
        (ROOT / "config/pose_stats.rviz").read_text(encoding="utf-8")
    )
    manager = config["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == "plate"
    topics = {
        display["Topic"]["Value"]: display["Topic"]
        for display in manager["Displays"]
        if "Topic" in display
    }
    assert set(topics) == {"/pose_stats/markers", BODY}
    # The node's markers are latched: whoever asks for less gets none that came before.
    assert topics["/pose_stats/markers"]["Durability Policy"] == "Transient Local"
    assert topics[BODY]["Durability Policy"] == "Volatile"


def panels(layout):
    """Names in a tree of panels."""
    if isinstance(layout, str):
        return [layout]
    return [*panels(layout["first"]), *panels(layout["second"])]


def test_foxglove_lays_out_every_panel_once_and_shows_topics_there_are():
    layout = json.loads(
        (ROOT / "config/pose_stats.foxglove.json").read_text(encoding="utf-8")
    )
    assert sorted(panels(layout["layout"])) == sorted(layout["configById"])
    topics = set(
        re.findall(
            r'"(/(?:pose_stats|drop)/\w+|/diagnostics)',
            json.dumps(layout["configById"]),
        )
    )
    assert topics == NODE | DROP
    page = (ROOT / "docs/node.md").read_text(encoding="utf-8")
    for topic in NODE:
        assert f"`{topic.replace('/pose_stats', '~')}`" in page
