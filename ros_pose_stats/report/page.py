"""The page: one HTML file that needs nothing beside itself."""

from __future__ import annotations

from ..text import several
from .feeder_section import feeder_section
from .findings import Findings
from .markup import (
    between,
    element,
    in_millimetres,
    millimetres,
    paragraph,
    percent,
    section,
    text,
)
from .method_sections import method_section, reproduce_section, table_section
from .pose_sections import MOST_SHOWN, methods_section, poses_section, viewer_section
from .shape_sections import graph_section, sphere_section
from .viewer import ASSETS, viewer_script
from .warning_words import in_words

POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"
"""The browser itself is told to load nothing."""


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
    shown = findings.simulated.poses[:MOST_SHOWN]
    sections = [_heading(findings), _warnings(findings), poses_section(findings, shown),
                viewer_section(findings, shown), methods_section(findings, shown),
                feeder_section(findings), graph_section(findings), sphere_section(findings),
                table_section(findings), method_section(findings),
                reproduce_section(findings, commands)]
    style = (ASSETS / "page.css").read_text(encoding="utf-8")
    name = text(findings.part.part_id)
    head = (f'<meta charset="utf-8"><title>{name}: resting poses</title>'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
            f'<link rel="icon" href="data:,"><style>{style}</style>')
    return (f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head><body><main>'
            f'{"".join(sections)}</main><script>{viewer_script()}</script></body></html>\n')


def _heading(findings: Findings) -> str:
    found, part = findings.simulated, findings.part
    best = found.poses[0]
    size = part.surface_vertices.max(axis=0) - part.surface_vertices.min(axis=0)
    extent = " \N{MULTIPLICATION SIGN} ".join(map(in_millimetres, size.tolist()))
    lead = (f"Dropped on a plate, this part comes to rest in "
            f"{several(len(found.poses), 'stable pose')}, most often in pose {best.index}: "
            f"{percent(best.probability)} of {found.drops} simulated drops (90 % interval "
            f"{between(best.probability_low, best.probability_high)}).")
    facts = (f"{extent} mm; {len(part.triangles)} triangles; the corner farthest from the centre "
             f"of mass is {millimetres(found.radius)} away. A real plate adds some "
             f"{100.0 * found.plate_error:.0f} points of its own to every probability.")
    return element("header", element("h1", f"{text(part.part_id)}: how it comes to rest")
                   + paragraph(lead, "lead") + paragraph(facts, "soft"))


def _warnings(findings: Findings) -> str:
    if not findings.warnings:
        return ""
    boxes = []
    for heading, sentence, meaning in map(in_words, findings.warnings):
        boxes.append(element("div", element("h3", text(heading))
                             + element("p", text(f"{sentence} {meaning}".strip())), "warning"))
    return section("Look twice", *boxes)
