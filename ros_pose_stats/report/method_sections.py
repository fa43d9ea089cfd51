"""The numbers of all poses, how they were found, and how to find them again."""

from __future__ import annotations

from ..text import several
from .findings import Findings
from .markup import (
    between,
    degrees,
    element,
    in_millimetres,
    millimetres,
    paragraph,
    percent,
    section,
    table,
    text,
    verbatim,
)

MOST_ROWS = 60
ROUNDING = 1e-9


def table_section(findings: Findings) -> str:
    """Every pose in a row."""
    found = findings.simulated
    rows = [[str(pose.index), str(pose.group), percent(pose.probability),
             between(pose.probability_low, pose.probability_high), str(pose.count),
             text(millimetres(pose.height)), text(millimetres(pose.top)),
             text(millimetres(pose.barrier)), degrees(pose.margin),
             " ".join(f"{x + 0.0:+.3f}" for x in pose.down.round(3))]
            for pose in found.poses[:MOST_ROWS]]
    heads = ("pose", "group", "probability", "90 % interval", "drops", "height", "highest point",
             "barrier", "margin", "down (x y z of the part)")
    rest = len(found.poses) - len(rows)
    more = "" if not rest else paragraph(
        f"{several(rest, 'more pose')} not listed; the command with --json lists all.", "soft")
    return section("All poses", table(heads, rows), more)


def method_section(findings: Findings) -> str:
    """What was computed, with which settings."""
    found, part = findings.simulated, findings.part
    best = findings.best_estimate
    rows = [
        ("simulation", f"{found.drops} drops of a rigid body on a rigid, horizontal, frictionless "
         f"plate; {found.unsettled} did not settle; expected error "
         f"{100.0 * found.expected_error:.2f} points"),
        ("restitution", f"{found.restitution:g}"),
        ("drop height", f"{millimetres(found.drop_height)}: the centre of mass at release, in a "
         "random orientation, at rest"),
        ("seed", str(found.seed)),
        ("estimates", "nine methods of P. L. Várkonyi, Estimating part pose statistics with "
         f"application to industrial parts feeding and shape design, and {best.method}, fitted to "
         "simulations, here with an expected error of "
         f"{100.0 * best.expected_error:.1f} points"),
        ("poses", f"merge where the ridge between them is lower than {found.cluster_tolerance:g} "
         "radii above both (cluster tolerance)"),
        ("centre of mass", " ".join(_coordinate(x, found.radius) for x in part.center_of_mass)
         + " mm in the part's frame"),
        ("not modelled", "parts that touch or tangle, friction, softness of the plate, motion of "
         "a bowl"),
    ]
    return section("Method and settings",
                   table(("", ""), [[text(name), text(value)] for name, value in rows], "plain"))


def _coordinate(metres: float, radius: float) -> str:
    """Millimetres; rounding is no place."""
    return "0" if abs(metres) < ROUNDING * radius else in_millimetres(metres)


def reproduce_section(findings: Findings, commands: tuple[str, ...]) -> str:
    """Commands, version and digest."""
    found = findings.simulated
    lines = element("pre", verbatim("\n".join(commands))) if commands else ""
    same = ("Drop k depends on the seed and k alone, so these give the same counts again on the "
            "same machine.") if commands else ""
    digest = f"ros_pose_stats {found.version}; digest of the part {found.part_digest}"
    return section("How to reproduce it", paragraph(same) if same else "", lines,
                   element("p", text(digest), "soft"))


