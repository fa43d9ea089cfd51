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

"""The page about variants: what it says of each beside the first, in words and
pictures.
"""

import numpy as np


def test_it_says_what_the_object_says(comparison):
    page, _, values = comparison
    assert "B feeds better: " in page.text or "A feeds better: " in page.text
    assert f"{values['drops']} drops of each variant" in page.text
    verdicts = [pair["on_plate"] for pair in values["comparisons"]]
    assert verdicts[:2] == ["difference shown", "none shown"]
    assert "; large enough to expect on a real plate" in page.text


def test_turned_and_foreign_variants_are_pointed_out(comparison):
    text = comparison[0].text
    assert "C is the same body as A, turned by" in text
    assert "Wanted of A, and without a partner in D" in text
    assert "D has no such pose" in text and "A has no such pose" in text


def test_names_cannot_write_html_and_the_command_that_gives_it_again_is_there(
    comparison,
):
    page, _, _ = comparison
    assert "<i>stone" not in page.source and "<i>stone & 'co'" in page.text
    assert (
        "ros_pose_stats compare " in page.text and "--drops 300 --seed 1" in page.text
    )


def test_every_pose_has_its_picture_and_a_turned_part_looks_as_the_first_one(
    comparison,
):
    """Pairs side by side: the clamp as it is, and as it lies turned in its file."""
    page, _, values = comparison
    counts = [
        sum(
            min(len(pose[side]), 1)
            for pose in pair["poses"][:12]
            for side in ("first", "second")
        )
        for pair in values["comparisons"]
    ]
    pictures = [picture.pixels for picture in page.pictures]
    assert len(pictures) == sum(counts)
    assert all(
        (picture < 250).any() and picture[0, 0].min() == 255 for picture in pictures
    )
    begin = counts[0]
    for left_box, right in zip(
        pictures[begin : begin + 6 : 2],
        pictures[begin + 1 : begin + 7 : 2],
        strict=True,
    ):
        # An edge may fall on the next pixel.
        assert np.mean(np.abs(left_box - right).max(axis=2) > 40) < 0.02
