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

"""The page that follows a file, in HTML: its frame, and what it says of a version."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...base.text import name_poses
from ...core.mesh.units import unit_in_words
from ...core.records.poses import PoseGroup
from ...core.records.statistics import listed_groups
from ...core.statistics.feeding import Bounded
from ...core.statistics.pose_groups import pose_groups
from ..report import words
from ..report.page import MOST_SHOWN, viewer_data
from .pushes import Pushes
from .versions import Change, History, Version

ASSETS = Path(__file__).parent / "assets"

LINE_WIDTH = 240.0
LINE_HEIGHT = 44.0
LINE_MARGIN = 5.0
LEAST_SPAN = 0.02
"""Of the line of shares: its size, and the least difference from bottom to top, so that
rounding does not look like mountains."""


def frame_page(name: str) -> str:
    """The page before anything is known; its script fills it."""
    return words.template("watching.html", ASSETS).render(name=name)


def page_script() -> str:
    """Script of the page."""
    own_script = (ASSETS / "watching.js").read_text()
    return (
        f'"use strict";\n(function () {{\n{words.viewer_scripts()}{own_script}}}());\n'
    )


class Card(NamedTuple):
    """What the page says of some like poses."""

    group: PoseGroup
    before: PoseGroup | None  # the same poses in the version before; None if new
    key: int  # that they keep from version to version
    is_wanted: bool


class Drawing(NamedTuple):
    """What stays of a version while its numbers change."""

    # first poses of the groups that have a card, in their order
    groups: tuple[int, ...]
    view: str  # as of `viewer_data`


def draw_version(version: Version) -> Drawing:
    """Choose what is shown of a version, by its estimate."""
    groups = listed_groups(pose_groups(version.estimate))[:MOST_SHOWN]
    poses = [group.first for group in groups]
    return Drawing(
        tuple(pose.index for pose in poses),
        viewer_data(version.part, poses, version.estimate.radius),
    )


def version_html(
    history: History,
    version: Version,
    drawing: Drawing,
    progress: str,
    trouble: str,
    pushes: Pushes | None,
) -> str:
    """What the page says of the present version.

    `progress`: of its drops, in words; `trouble`: why a later save is not shown;
    `pushes`: None as long as they are looked for.
    """
    statistics = version.answer
    groups = pose_groups(statistics)
    cards = _cards(history, version, groups, drawing.groups)
    shown = sum(card.group.probability for card in cards)
    hidden = len(statistics.poses) - sum(card.group.size for card in cards)
    changes = [
        (name, before.number, _in_typography(change))
        for name, before in _earlier_versions(history)
        for change in [history.change_since(before)]
        if change is not None
    ]
    lost = len(history.wanted_keys) - len(version.poses_of(history.wanted_keys))
    return words.template("version.html", ASSETS, named=_name_group).render(
        version=version,
        statistics=statistics,
        subject=history.subject,
        share=history.share(version, statistics),
        lost=lost,
        changes=changes,
        cards=cards,
        follows=history.previous is not None,
        hidden=hidden,
        rest=max(0.0, 1.0 - shown),
        line=share_line(history.shares),
        progress=progress,
        trouble=trouble,
        pushes=pushes,
        size=np.ptp(version.part.surface_vertices, axis=0).tolist(),
        unit=unit_in_words(statistics.unit),
        warnings=[
            words.in_words(warning) for warning in statistics.warnings if warning.acts
        ],
    )


def _earlier_versions(history: History) -> list[tuple[str, Version]]:
    """Versions that the present one is set beside, each once, and what they are."""
    named_versions = [("last version", history.previous), ("start", history.start)]
    if history.previous is not None and history.previous.number == 1:
        del named_versions[1]
    return [(name, version) for name, version in named_versions if version is not None]


def waiting_html(name: str, trouble: str) -> str:
    """What the page says before the first version."""
    return words.template("waiting.html", ASSETS).render(name=name, trouble=trouble)


def _cards(
    history: History,
    version: Version,
    groups: Sequence[PoseGroup],
    shown: Sequence[int],
) -> list[Card]:
    """Cards of some groups, named by their first poses, with what they were before."""
    previous = history.previous
    group_by_key = {}
    if previous is not None:
        statistics = previous.answer if version.answer.drops else previous.estimate
        group_by_key = {
            previous.keys[index]: group
            for group in pose_groups(statistics)
            for index in group.indices
        }
    group_of = {group.first.index: group for group in groups}
    cards = []
    for index in shown:
        group = group_of[index]
        keys = [version.keys[pose] for pose in group.indices]
        known = [group_by_key[key] for key in keys if key in group_by_key]
        cards.append(
            Card(
                group,
                known[0] if known else None,
                keys[0],
                history.has_feeder and bool(set(keys) & set(history.wanted_keys)),
            )
        )
    return cards


class ShareLine(NamedTuple):
    """The shares of all versions as a line, in the units of its drawing."""

    points: tuple[tuple[float, float], ...]  # across and down
    low: float  # shares at the bottom and at the top
    high: float

    @property
    def path(self) -> str:
        """As SVG writes it."""
        return " ".join(f"{x:.1f},{y:.1f}" for x, y in self.points)


def share_line(shares: Sequence[Bounded]) -> ShareLine | None:
    """The line of two versions or more."""
    if len(shares) < 2:
        return None
    values = np.array([share.value for share in shares])
    middle = 0.5 * (values.min() + values.max())
    span = max(LEAST_SPAN, np.ptp(values))
    across = np.linspace(LINE_MARGIN, LINE_WIDTH - LINE_MARGIN, len(values))
    height = LINE_HEIGHT - 2.0 * LINE_MARGIN
    down = 0.5 * LINE_HEIGHT - height * (values - middle) / span
    return ShareLine(
        tuple(zip(across.tolist(), down.tolist(), strict=True)),
        float(values.min()),
        float(values.max()),
    )


def _in_typography(change: Change) -> str:
    return words.units(str(change).replace("->", "\N{RIGHTWARDS ARROW}"))


def _name_group(group: PoseGroup) -> str:
    return name_poses(group.indices).replace(" ", words.SPACE, 1)
