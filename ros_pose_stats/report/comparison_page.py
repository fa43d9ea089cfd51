"""The page about variants of a part: one HTML file that needs nothing beside itself."""

import math
from functools import cache
from typing import Any

import numpy as np
from jinja2 import Template

from ..design.comparison import NONE_SHOWN, SHOWN, Comparison, PoseComparison, VariantComparison
from ..design.describe import describe_matching, describe_verdict, letter, name_warnings
from ..plots.files import png_bytes
from ..plots.poses import pictures_beside
from ..records import PoseStatistics, StablePose
from ..text import ranges
from . import page, words

MOST_SHOWN = 12
"""Pairs of poses with pictures, the most frequent ones; the table lists more."""

MOST_ROWS = 60


def comparison_page(found: Comparison, commands: tuple[str, ...] = ()) -> str:
    """Write the page of a comparison.

    `found`: of at least one drop; `commands`: commands that give the same answer again. Returns
    HTML. No script, style, font or picture comes from anywhere else.
    """
    named = [f"{letter(place)} {one.part_id}" for place, one in enumerate(found.found)]
    sizes = [1e3 * np.ptp(part.surface_vertices, axis=0) for part in found.parts]
    return _template().render(
        found=found, named=named, first=found.found[0],
        sizes=[" × ".join(f"{x:.4g}" for x in size) for size in sizes],
        centers=[" ".join(f"{x + 0.0:.4g}" for x in np.round(1e3 * part.center_of_mass, 4))
                 for part in found.parts],
        sections=[_section(found, one) for one in found.variants],
        warnings=[(whose, *words.in_words(line)) for line, whose in name_warnings(found).items()],
        commands=commands,
        style=(page.ASSETS / "page.css").read_text(encoding="utf-8")
        + (page.ASSETS / "comparison.css").read_text(encoding="utf-8"))


def _section(found: Comparison, one: VariantComparison) -> dict[str, Any]:
    """What the page says of the first variant beside another one."""
    shown = one.poses[:MOST_SHOWN]
    pairs = [(_first(found.found[0], pose.poses.first),
              _first(found.found[one.second], pose.poses.second)) for pose in shown]
    radius = max(found.found[0].radius, found.found[one.second].radius)
    pictures = pictures_beside((found.parts[0], found.parts[one.second]),
                               one.correspondence.turn, pairs, radius)
    return {"other": letter(one.second), "comparison": one,
            "verdict": describe_verdict(found, one), "matching": describe_matching(one),
            "cards": [(pose, [None if each is None else page.address("png", png_bytes(each))
                             for each in pair])
                      for pose, pair in zip(shown, pictures, strict=True)],
            "warnings": [words.in_words(line) for line in one.warnings]}


def _first(found: PoseStatistics, poses: tuple[int, ...]) -> StablePose | None:
    return next((pose for pose in found.poses if poses and pose.index == poses[0]), None)


@cache
def _template() -> Template:
    return page.template("comparison.html", {"MOST_ROWS": MOST_ROWS, "verdict": _verdict}, {
        "points": _points, "numbered": _numbered,
        "of_bar": lambda share: f"{100.0 * share:.2f}"})


def _verdict(pose: PoseComparison) -> str:
    """What is to be read of a pose at a glance."""
    if pose.share.on_plate == SHOWN:
        return SHOWN
    return "shown in the model only" if pose.share.in_model == SHOWN else NONE_SHOWN


def _points(fraction: float) -> str:
    """A signed difference in points."""
    if math.isnan(fraction):
        return "\N{EN DASH}"
    rounded = round(100.0 * fraction, 1)
    return f"{rounded:+.1f}".replace("-", "\N{MINUS SIGN}") if rounded else "0.0"


def _numbered(poses: tuple[int, ...]) -> str:
    text = ranges(poses).replace("-", words.RANGE)
    return f"pose{'s' if len(poses) > 1 else ''}{words.SPACE}{text}" if poses else "no partner"
