"""The page about a part: one HTML file that needs nothing beside itself."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from numpy.typing import NDArray

from ..plots.files import png_bytes, svg_bytes
from ..plots.poses import pose_pictures
from ..plots.reachable import reachable_figure, telling_energies
from ..plots.sphere import sphere_figure
from ..plots.splitting import MOST, drawn_tree, splitting_figure
from ..records import StablePose
from ..text import listed, several
from . import words
from .feeding import Feeding, feeding
from .findings import Findings
from .viewer import ASSETS, viewer_data, viewer_script

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_SHOWN = 12
"""Poses with a picture, the most frequent ones; the table lists more."""

LIMITS = {
    "MOST_ROWS": 60,  # of the table of all poses
    "MOST_GROUPS": 6,  # of poses that are alike
    "MOST_ENDS": MOST,  # of the splitting graph
    "FITTING": 6,  # ends of it that can be read at a phone's width; more are pushed sideways
    "BESIDE": 9,  # ends of it that leave room for another figure beside it
}
MOST_FEEDERS, MOST_ALIKE = 12, 8
"""Most rows about the feeder, and most poses of a group that are named."""

ROUNDING = 1e-9


def report_page(findings: Findings, commands: tuple[str, ...] = ()) -> str:
    """Write the page of a part.

    Parameters
    ----------
    findings : Findings
    commands : tuple of str
        Commands that give the same numbers again, for the section that says so.

    Returns
    -------
    str
        HTML. No script, style, font or picture comes from anywhere else.
    """
    part, found = findings.part, findings.simulated
    shown = found.poses[:MOST_SHOWN]
    pictures = pose_pictures(part, shown, found.radius)
    size = part.surface_vertices.max(axis=0) - part.surface_vertices.min(axis=0)
    return _template().render(
        part=part, found=found, estimate=findings.best_estimate, wanted=findings.wanted,
        shown=shown, size=size.tolist(), commands=commands,
        center=[_coordinate(x, found.radius) for x in part.center_of_mass.tolist()],
        warnings=[words.in_words(one) for one in findings.warnings],
        cards=[(pose, _address("png", png_bytes(picture)))
               for pose, picture in zip(shown, pictures, strict=True)],
        by_method=_by_method(findings, shown),
        feeders=[feeding(found, (pose.index,)) for pose in found.poses[:MOST_FEEDERS]],
        alike=_alike(findings), graph=_graph(findings),
        spheres={name: _svg_text(sphere_figure(findings.sphere, name, findings.graph))
                 for name in ("R", "r")},
        view=viewer_data(part, shown, found.radius), script=viewer_script(),
        style=(ASSETS / "page.css").read_text(encoding="utf-8"))


@cache
def _template() -> Template:
    """The page with places for what is known; all that is put in is escaped."""
    known = Environment(loader=FileSystemLoader(ASSETS), autoescape=True, trim_blocks=True,
                        lstrip_blocks=True, undefined=StrictUndefined, keep_trailing_newline=True)
    known.globals.update(LIMITS, between=words.between, several=several)
    known.filters.update(
        percent=words.percent, millimetres=words.millimetres, degrees=words.degrees,
        in_millimetres=words.in_millimetres, three_digits=words.three_digits, units=words.units,
        listed=listed, is_finite=math.isfinite, named=_named, direction=_direction,
        times=lambda passes: words.three_digits(passes) if math.isfinite(passes) else "no bound",
        share_of_bar=lambda share: f"{0.0 if math.isnan(share) else 100.0 * share:.2f}")
    return known.get_template("page.html")


def _by_method(findings: Findings, shown: Sequence[StablePose]) -> list[tuple[StablePose, Any]]:
    """Each pose with the answer of every method."""
    every = [findings.simulated, findings.hybrid, *findings.estimates]
    known = [(found, {pose.index: pose for pose in found.poses}) for found in every]
    return [(pose, [(found, poses[pose.index]) for found, poses in known]) for pose in shown]


def _alike(findings: Findings) -> list[Feeding]:
    """Groups of poses that are the same by symmetry, and the share of the drops in each."""
    groups: dict[int, list[int]] = {}
    for pose in findings.simulated.poses:
        groups.setdefault(pose.group, []).append(pose.index)
    return [feeding(findings.simulated, sorted(members)) for members in groups.values()
            if len(members) > 1]


def _graph(findings: Findings) -> dict[str, Any] | None:
    """The splitting graph, the reachable sets, and how many ends are drawn (Figs. 3C-F)."""
    root = findings.graph
    if root.level is None:
        return None
    return {"ends": sum(not branch.parts for branch in drawn_tree(root).walk()),
            "splitting": _svg_text(splitting_figure(root, findings.simulated.poses)),
            "reachable": _svg_text(
                reachable_figure(findings.sphere, root, telling_energies(root)))}


def _svg_text(figure: Figure) -> str:
    return _address("svg+xml", svg_bytes(figure))


def _address(kind: str, picture: bytes) -> str:
    """A picture as an address that contains its data."""
    return f"data:image/{kind};base64,{base64.b64encode(picture).decode()}"


def _named(members: Sequence[int]) -> str:
    if len(members) <= MOST_ALIKE:
        return listed(members)
    first = ", ".join(map(str, members[:MOST_ALIKE - 2]))
    return f"{first}, ... ({len(members)} in all)"


def _direction(down: NDArray[np.float64]) -> str:
    return " ".join(f"{x + 0.0:+.3f}" for x in down.round(3))


def _coordinate(metres: float, radius: float) -> str:
    """A coordinate in millimetres; 0 where it is only rounding."""
    return "0" if abs(metres) < ROUNDING * radius else words.in_millimetres(metres)
