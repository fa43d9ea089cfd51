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

"""`fit`: a plate learnt from a bag of counts, in words and in the file; tables are
tested with the library's plates.
"""

import re
from array import array

import pytest
import yaml
from ros_pose_stats_msgs.msg import PartMesh

from lab.bodies import shapes
from ros_pose_stats import part_from_mesh, simulate
from tests.contract.bags.messages import counts, numbering_of, result
from tests.contract.bags.recorders import write_run
from tests.running import call, refusal

SIZES = {"\x1b[31mslab": (0.020, 0.030, 0.012), "die": (0.010, 0.010, 0.0075)}


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """Two parts counted on two plates, and a third that nobody knows."""
    messages = []
    for second, (name, size) in enumerate(SIZES.items()):
        part = part_from_mesh(*shapes.box(*size))
        numbered = {"part_digest": part.digest, "cluster_tolerance": 0.0025}
        information = {
            "part_id": name,
            "numbering": numbering_of(part.digest, 0.0025),
        }
        drops = simulate(part, 300, 0.4, 9, 0.05)
        shares = [
            pose.count for pose in sorted(drops.poses, key=lambda pose: pose.index)
        ]
        messages += [
            (
                "part_mesh",
                PartMesh(
                    part_id=name,
                    vertices=array("d", part.vertices.ravel().tolist()),
                    triangles=array("I", part.triangles.ravel().tolist()),
                ),
            ),
            (
                "pose_statistics",
                result(
                    2.0 * second,
                    [share / 300 for share in shares],
                    group=range(6),
                    part_id=name,
                    **numbered,
                ),
            ),
            ("pose_counts", counts(2.0 * second, shares, plate="glass", **information)),
            (
                "pose_counts",
                counts(
                    2.0 * second + 1, [0, 0, 0, 0, 0, 999], plate="other", **information
                ),
            ),
        ]
    messages.append(
        (
            "pose_counts",
            counts(9.0, (5, 5), part_id="\x1b[2Jlost", plate="glass", numbering=7),
        )
    )
    return write_run(tmp_path_factory.mktemp("log"), messages)


def test_a_bag_gives_the_counts_of_its_parts_on_the_plate(bag, tmp_path):
    file = tmp_path / "plates.yaml"
    file.write_text("plates:\n  steel: {restitution: 0.2}\n")
    outcome = call("fit", bag, bag, "--plate", "glass", "--plates", file)
    assert outcome.returncode == 0, outcome.stderr
    assert outcome.stdout.splitlines()[0] == "plate glass, from 600 counts of 2 parts"
    assert f"wrote {file}" in outcome.stdout
    assert re.match("(do not )?use it", outcome.stdout.splitlines()[-1])
    assert "10 counts of ?[2Jlost left out: its mesh is not in the bags" in (
        outcome.stderr
    )
    assert "?[31mslab" in outcome.stdout
    assert "\x1b" not in outcome.stdout + outcome.stderr
    plates = yaml.safe_load(file.read_text(encoding="utf-8"))["plates"]
    assert plates["steel"] == {"restitution": 0.2}
    assert (plates["glass"]["counted"], {*plates["glass"]["parts"]}) == (600, {*SIZES})


def test_a_plate_that_nobody_counted_on_is_refused(bag, tmp_path):
    line = refusal("fit", bag, "--plate", "steel", "--plates", tmp_path / "plates.yaml")
    assert "got those of glass and other" in line and not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("other: 1\n", "--plates"),
        (
            yaml.safe_dump({"plates": {f"p{k}": {} for k in range(256)}}),
            "256 plates, got 257",
        ),
    ],
)
def test_a_file_of_something_else_or_a_full_one_is_refused_and_kept(
    bag, tmp_path, text, words
):
    file = tmp_path / "plates.yaml"
    file.write_text(text)
    assert words in refusal("fit", bag, "--plate", "glass", "--plates", file)
    assert file.read_text() == text
