"""The poses: pictures on the plate, the 3-D view, and probabilities by method."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..plots.files import png_bytes
from ..plots.poses import pose_pictures
from ..records import PoseStatistics, StablePose
from ..text import several
from .findings import Findings
from .markup import (
    between,
    degrees,
    element,
    millimetres,
    paragraph,
    percent,
    picture,
    section,
    text,
)
from .viewer import viewer_data

MOST_SHOWN = 12
"""Poses with a picture, the most frequent ones; the table lists more."""


def poses_section(findings: Findings, shown: Sequence[StablePose]) -> str:
    """A card a pose: picture, probability, height, barrier and margin."""
    found = findings.simulated
    pictures = pose_pictures(findings.part, shown, found.radius)
    cards = [_card(pose, png_bytes(image), place)
             for place, (pose, image) in enumerate(zip(shown, pictures, strict=True))]
    rest = found.poses[len(shown):]
    more = "" if not rest else paragraph(
        f"{several(len(rest), 'more pose')}, together "
        f"{percent(sum(pose.probability for pose in rest))}, "
        f"{'is' if len(rest) == 1 else 'are'} listed in the table below.", "soft")
    legend = paragraph(
        f"Pictures are to one scale; the plate is {millimetres(2.1 * found.radius)} wide. Bars: "
        f"share of {found.drops} simulated drops, the black line is the 90 % interval. Height: "
        "of the centre of mass. Barrier: how far the centre of mass must rise before the part can "
        "leave the pose. Margin: the smallest tilt of the plate that topples it.", "soft")
    return section("Stable poses", legend, element("div", "".join(cards), "cards"), more)


def _card(pose: StablePose, image: bytes, place: int) -> str:
    what = (f"The part in pose {pose.index}, {percent(pose.probability)} of the drops")
    facts = [("90 % interval", between(pose.probability_low, pose.probability_high)),
             ("height", millimetres(pose.height)), ("barrier", millimetres(pose.barrier)),
             ("margin", degrees(pose.margin)), ("highest point", millimetres(pose.top))]
    if pose.spread > 0.0:
        facts.append((f"{len(pose.members)} facets", f"up to {degrees(pose.spread)} apart"))
    listed = "".join(element("dt", text(name)) + element("dd", text(value))
                     for name, value in facts)
    heading = element("h3", element("span", f"Pose {pose.index}")
                      + element("span", percent(pose.probability)))
    return element("div", heading + picture(image, "png", what) + bar(
        pose.probability, pose.probability_low, pose.probability_high)
        + element("dl", listed), "card", data_show=str(place))


def bar(share: float, low: float, high: float, css: str = "") -> str:
    """A bar from 0 to 100 % with its interval."""
    value = 0.0 if math.isnan(share) else share
    filled = f'<i class="{css}" style="width:{100.0 * value:.2f}%"></i>'
    if not (math.isnan(low) or math.isnan(high)):
        low, high = max(low, 0.0), min(high, 1.0)
        filled += f'<b style="left:{100.0 * low:.2f}%;width:{100.0 * (high - low):.2f}%"></b>'
    return element("div", filled, "bar")


def viewer_section(findings: Findings, shown: Sequence[StablePose]) -> str:
    """The part on the plate, to be turned."""
    buttons = "".join(element("button", f"pose {pose.index}", type="button",
                              aria_pressed="false") for pose in shown)
    data = viewer_data(findings.part, shown, findings.simulated.radius)
    return section(
        "In three dimensions",
        element("noscript", paragraph("The view needs JavaScript; the pictures above do not.")),
        element("div", buttons, id="poses-of-view", role="group", aria_label="pose shown"),
        '<canvas id="view" tabindex="0" role="img" aria-label="the part on the plate; arrow keys '
        'turn it"></canvas>',
        paragraph("Drag to turn, or use the arrow keys; a double click sets it back.", "soft"),
        f'<script type="application/json" id="part-data">{data}</script>', css="viewer")


def methods_section(findings: Findings, shown: Sequence[StablePose]) -> str:
    """Every method's probability of every pose, with intervals."""
    every = [findings.simulated, findings.hybrid, *findings.estimates]
    by_index = [{pose.index: pose for pose in found.poses} for found in every]
    blocks = []
    for pose in shown:
        rows = [_method_row(found, known[pose.index])
                for found, known in zip(every, by_index, strict=True)]
        blocks.append(element("div", element("h3", f"Pose {pose.index}") + "".join(rows)))
    counted = f"simulation, {findings.simulated.drops} drops; hybrid"
    key = (f'<div class="bar"><i style="width:100%"></i></div>{counted}',
           '<div class="bar"><i class="quick" style="width:100%"></i></div>quick estimates',
           '<div class="bar"><b style="left:15%;width:70%"></b></div>90 % interval')
    about = paragraph(
        "Bars go from 0 to 100 %. The interval of the simulation is that of its counts. Hybrid "
        "takes an estimate as if it were drops already made. The interval of an estimate is what "
        "the method erred by on parts like this one. All are against the model, not a real "
        "plate.", "soft")
    return section("Probabilities by method", about,
                   element("div", "".join(element("span", one) for one in key), "key"),
                   element("div", "".join(blocks), "methods"))


def _method_row(found: PoseStatistics, pose: StablePose) -> str:
    counted = found.drops > 0
    low, high = pose.probability_low, pose.probability_high
    return element("div", element("span", text(found.method))
                   + bar(pose.probability, low, high, "" if counted else "quick")
                   + element("span", percent(pose.probability)),
                   "method first" if counted else "method",
                   title=f"{found.method}, pose {pose.index}: {percent(pose.probability)}, "
                   f"90 % interval {between(low, high)}")
