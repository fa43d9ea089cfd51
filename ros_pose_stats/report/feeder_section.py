"""What the probabilities mean for a feeder."""

from __future__ import annotations

import math

from ..text import listed, several
from .feeding import Feeding, feeding
from .findings import Findings
from .markup import between, element, paragraph, percent, section, table, text, three_digits

MOST_ROWS = 12
MOST_ALIKE, MOST_GROUPS = 8, 6
"""Poses of a group that are named, and groups."""

FRESH = ("A part that is sent back is taken as dropped afresh: its next pose does not depend on "
         "the last one.")


def feeder_section(findings: Findings) -> str:
    """Share of parts in each pose, and what a feeder that keeps some of them gets."""
    found = findings.simulated
    answer = "" if findings.wanted is None else _answer(findings.wanted, found.plate_error)
    rows = []
    for pose in found.poses[:MOST_ROWS]:
        one = feeding(found, (pose.index,))
        rows.append([f"pose {pose.index}", _with(percent(one.share), between(one.low, one.high)),
                     _passes(one)])
    heads = ("if only this is kept", "share of parts (90 %)", "passes per accepted part (90 %)")
    groups = _groups(findings)
    return section("What it means for a feeder", answer, table(heads, rows), groups,
                   paragraph(f"Passes per accepted part are 1/p. {FRESH}", "soft"), css="together")


def _answer(wanted: Feeding, plate_error: float) -> str:
    several = "poses" if len(wanted.wanted) > 1 else "pose"
    share = (f"Accepting {several} {listed(wanted.wanted)} keeps {percent(wanted.share)} of the "
             f"parts (90 % interval {between(wanted.low, wanted.high)}).")
    middle, least, most = wanted.passes
    passes = (f"{_times(middle)} passes per accepted part ({_times(least)} to {_times(most)})."
              if math.isfinite(most) else f"More than {_times(least)} passes per accepted part.")
    lines = [element("p", text(share))]
    if math.isfinite(wanted.rate):
        rate, low, high = wanted.accepted
        lines.append(element("p", element("strong", text(
            f"{three_digits(rate)} accepted parts a minute")) + text(
            f" ({three_digits(low)} to {three_digits(high)}) where {wanted.rate:g} are dropped a "
            "minute, those sent back included.")))
    lines.append(element("p", element("strong", text(passes)) + text(f" {FRESH}")))
    lines.append(element("p", text(
        f"The interval is that of the simulation; a real plate may shift the share by some "
        f"{100.0 * plate_error:.0f} points."), "soft"))
    return element("div", "".join(lines), "answer")


def _groups(findings: Findings) -> str:
    """Poses that are one and the same for a symmetric part."""
    groups: dict[int, list[int]] = {}
    for pose in findings.simulated.poses:
        groups.setdefault(pose.group, []).append(pose.index)
    alike = [sorted(members) for members in groups.values() if len(members) > 1]
    if not alike:
        return ""
    words = "; ".join(
        f"poses {_named(members)}, {percent(feeding(findings.simulated, members).share)} together"
        for members in alike[:MOST_GROUPS])
    rest = len(alike) - MOST_GROUPS
    more = f"; and {several(rest, 'more group')}" if rest > 0 else ""
    return paragraph("The part is symmetric and looks the same in some of its poses, so that a "
                     f"feeder may keep all of a group: {words}{more}.")


def _named(members: list[int]) -> str:
    if len(members) <= MOST_ALIKE:
        return listed(members)
    first = ", ".join(map(str, members[:MOST_ALIKE - 2]))
    return f"{first}, ... ({len(members)} in all)"


def _with(value: str, interval: str) -> str:
    """A value and its interval as the content of a cell."""
    return text(value) + element("small", text(f"({interval})"))


def _passes(one: Feeding) -> str:
    middle, least, most = one.passes
    if not math.isfinite(most):
        return text(f"more than {_times(least)}")
    return _with(_times(middle), f"{_times(least)} to {_times(most)}")


def _times(passes: float) -> str:
    if not math.isfinite(passes):
        return "no bound"
    return three_digits(passes)
