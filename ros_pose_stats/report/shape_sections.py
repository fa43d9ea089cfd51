"""The idea behind the estimates: splitting graph, sphere of poses and reachable sets."""

from __future__ import annotations

from ..plots.files import svg_bytes
from ..plots.reachable import reachable_figure, telling_energies
from ..plots.sphere import Function, sphere_figure
from ..plots.splitting import MOST, drawn_tree, splitting_figure
from .findings import Findings
from .markup import element, figure, paragraph, picture, section

FITTING, BESIDE = 6, 9
"""Ends of a splitting graph that can be read at a phone's width (more are pushed sideways), and
that leave room for another figure beside it."""

CAPTIONS: tuple[tuple[Function, str], ...] = (
    ("R", "R(u): how high the centre of mass is with the direction u pointing down. A part rolls "
     "downhill here; its stable poses are the lowest points."),
    ("r", "r(u): the distance from the centre of mass to the surface in the direction u. It "
     "touches R at every equilibrium."),
)


def graph_section(findings: Findings) -> str:
    """The splitting graph and the reachable sets (Figs. 3C-F)."""
    poses = findings.simulated.poses
    if findings.graph.level is None:
        return section("How the poses part", paragraph("There is one stable pose only."))
    ends = sum(not branch.parts for branch in drawn_tree(findings.graph).walk())
    image = picture(svg_bytes(splitting_figure(findings.graph, poses)), "svg+xml",
                    "Splitting graph: sets of poses, the energies at which they part, and the "
                    "probability of each way", "broad" if ends > FITTING else "")
    cut = (f" The graph of {len(poses)} poses is opened to at most {MOST} ends, where it is most "
           "probable; what parts farther down stays together." if len(poses) > MOST else "")
    about = ("A part that has just been dropped can reach every pose. As it loses energy, poses "
             "that are parted by a ridge can no longer be reached from each other: the set falls "
             "apart, from the top down. Boxes are sets of poses, circles single ones.")
    caption = ("At each split: the probability of going on into each of the sets, from the solid "
               "angles of r below that level (method meae). Below each pose: the probability of "
               "ending there by that method, and the height of the centre of mass. The scale "
               f"names the splits; those too close to be read are set apart.{cut}")
    energies = telling_energies(findings.graph)
    reached = picture(svg_bytes(reachable_figure(findings.sphere, findings.graph, energies)),
                      "svg+xml", "Poses that can be reached at falling energies")
    sets = ("Poses that can still be reached, just below the splits that matter most. Each disc "
            "is half of all directions of the part that may point down; see the next section.")
    return section("How the poses part", paragraph(about), element(
        "div", figure(image, caption) + figure(reached, sets), "" if ends > BESIDE else "pair"),
        css="together")


def sphere_section(findings: Findings) -> str:
    """r, R and the basins on the sphere of poses (Fig. 1C)."""
    sphere, root = findings.sphere, findings.graph
    pair = "".join(
        figure(picture(svg_bytes(sphere_figure(sphere, name, root)), "svg+xml",
                       f"Contours of {name} over both hemispheres of poses, with basins"), caption)
        for name, caption in CAPTIONS)
    about = ("Every point is a direction of the part that may point down. Each disc shows half of "
             "all directions, seen from outside the part; equal areas are equally probable for a "
             "part that is released in a random orientation.")
    return section("The sphere of poses", paragraph(about), element("div", pair, "pair"),
                   css="together")
