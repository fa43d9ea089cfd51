"""Pages about a part and its variants: each one HTML file that needs nothing beside itself."""

import base64
import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...base.text import name_poses, ranges
from ...core.mesh.decimation import visible_triangles
from ...core.records import Array, Part, StablePose
from ...core.records.poses import PoseGroup, single_poses
from ...core.statistics import feeding, pose_groups
from ..design import comparison, describe
from ..plots import changes, figures, poses, shares, sphere, splitting
from . import words
from .findings import Findings


def viewer_data(part: Part, poses: Sequence[StablePose], radius: float) -> str:
    """Mesh and poses as JSON, lengths in radii.

    `vertices`: base64 of little-endian float32, three a vertex, about the centre of mass;
    `triangles`: base64 of little-endian uint16, or uint32 where `wide`.
    """
    corners = (visible_triangles(part) - part.center_of_mass).reshape(-1, 3)
    # Integers of 16 bits would do for the places, but not for the normals of thin triangles, which
    # a fine circle in a flat face has many of.
    places = (corners / radius).astype("<f4") + np.float32(0.0)  # no negative zeros
    vertices, triangles = np.unique(places, axis=0, return_inverse=True)
    wide = len(vertices) > 65_535
    numbers = triangles.reshape(-1).astype("<u4" if wide else "<u2")
    return json.dumps(
        {
            "vertices": base64.b64encode(
                np.ascontiguousarray(vertices).tobytes()
            ).decode(),
            "triangles": base64.b64encode(numbers.tobytes()).decode(),
            "wide": wide,
            "poses": [
                {
                    "index": pose.index,
                    "label": f"{pose.index}",
                    "turn": [round(float(x), 9) for x in pose.orientation],
                    "height": round(pose.height / radius, 9),
                }
                for pose in poses
            ],
        },
        separators=(",", ":"),
    )


MOST_SHOWN = 12
"""Groups of like poses, or pairs of two variants, with a picture: the most frequent ones; the
table lists more."""

LIMITS = {
    "MOST_ROWS": 60,  # of the tables of all poses
    "MOST_ENDS": splitting.MOST,  # of the splitting graph
    "FITTING": 6,  # ends of it that can be read at a phone's width; more are pushed sideways
    "MOST_TURNED": 14,  # poses in the table of flips
    "BESIDE": 9,  # ends of it that leave room for another figure beside it
}
MOST_FEEDERS = 12
MOST_NAMED = 24
"""Most rows about the feeder, and characters that name the poses of a group."""

MOST_EFFECTS = 12  # changes of the part that are listed
ROUNDING = 1e-9  # coordinates of the centre of mass, in radii, that are shown as 0


def report_page(findings: Findings, commands: tuple[str, ...] = ()) -> str:
    """The page of a part as HTML; `commands`: those that give the same numbers again."""
    part = findings.part
    found = findings.simulated
    groups = pose_groups.pose_groups(found)
    shown = groups[:MOST_SHOWN]
    first = [group.first for group in shown]
    pictures = poses.pose_pictures(part, first, found.radius)
    return words.template(
        "page.html", named=_named, numbered=_numbered, direction=_direction
    ).render(
        **LIMITS,
        single_poses=single_poses,
        part=part,
        found=found,
        target=findings.target_error,
        estimate=findings.best_estimate,
        feeder=findings.feeder,
        afresh=findings.afresh,
        kicked=findings.kicked,
        groups=groups,
        shown=shown,
        size=np.ptp(part.surface_vertices, axis=0).tolist(),
        commands=commands,
        center=[
            "0" if abs(x) < ROUNDING * found.radius else words.in_millimetres(x)
            for x in part.center_of_mass.tolist()
        ],
        missed=any(one.startswith("TARGET_MISSED") for one in found.warnings),
        **{
            kind: [words.in_words(one) for one in getattr(findings, kind)]
            for kind in ("warnings", "cautions")
        },
        notes=[words.in_words(one) for one in found.notes],
        cards=[
            (group, figures.address("png", figures.png_bytes(picture)))
            for group, picture in zip(shown, pictures, strict=True)
        ],
        by_method=_by_method(findings, shown),
        feeders=[]
        if found.drops == found.unsettled
        else [
            (group, feeding.drop_afresh(pose_groups.pose_shares(found), group.indices))
            for group in groups[:MOST_FEEDERS]
        ],
        kicks=_kicks(findings),
        graph=_graph(findings),
        changes=_changes(findings),
        spheres={
            name: figures.svg_address(
                sphere.sphere_figure(findings.sphere, name, findings.graph)
            )
            for name in ("R", "r")
        },
        view=viewer_data(part, first, found.radius),
    )


def _kicks(findings: Findings) -> str | None:
    """What the feeder gets by its own kick and by others, as a picture."""
    feeder = findings.feeder
    afresh = findings.afresh
    if not findings.kicks or afresh is None or feeder.rate is None:
        return None
    return figures.svg_address(
        shares.kick_figure(
            findings.part.part_id,
            feeder.rate,
            feeder.cycle_time,
            afresh.per_minute,
            [
                (kick.flips.kick_height, kick.feeding.per_minute)
                for kick in findings.kicks
            ],
        )
    )


def _by_method(
    findings: Findings, shown: Sequence[PoseGroup]
) -> list[tuple[PoseGroup, Any]]:
    """Each group of poses with the answer of every method."""
    every = [findings.simulated, findings.hybrid, *findings.estimates]
    known = [
        (found, {group.first.index: group for group in pose_groups.pose_groups(found)})
        for found in every
    ]
    return [
        (group, [(found, groups[group.first.index]) for found, groups in known])
        for group in shown
    ]


def _graph(findings: Findings) -> dict[str, Any] | None:
    """The splitting graph, the reachable sets, and how many ends are drawn (Figs. 3C-F)."""
    root = findings.graph
    if root.level is None:
        return None
    return {
        "ends": sum(not branch.parts for branch in splitting.drawn_tree(root).walk()),
        "splitting": figures.svg_address(
            splitting.splitting_figure(root, findings.simulated.poses)
        ),
        "reachable": figures.svg_address(
            sphere.reachable_figure(
                findings.sphere, root, sphere.telling_energies(root)
            )
        ),
    }


def _changes(findings: Findings) -> dict[str, Any] | None:
    """What changes of the part do: a picture, and the greatest effects in words."""
    found = findings.sensitivity
    if found is None:
        return None
    return {
        "picture": figures.address(
            "png", figures.figure_png(changes.changes_figure(found))
        ),
        "found": found,
        "gain": found.describe_gain(),
        "rows": [
            (describe.name_step(found.space, one.number, one.step), one)
            for one in found.best[:MOST_EFFECTS]
        ],
        "judged": describe.JUDGED,
        "contradicted": describe.CONTRADICTED,
    }


def _named(group: PoseGroup) -> str:
    return f"pose{'s' if group.size > 1 else ''}{words.SPACE}{_numbered(group)}"


def _numbered(group: PoseGroup) -> str:
    """Numbers of the poses of a group; the last ones are left out of a long list."""
    text = ranges(group.indices).replace("-", words.RANGE)
    if len(text) <= MOST_NAMED:
        return text
    return f"{text[:MOST_NAMED].rpartition(',')[0]}, ... ({group.size} in all)"


def _direction(down: Array) -> str:
    return " ".join(f"{x + 0.0:+.3f}" for x in down.round(3))


def comparison_page(
    found: comparison.Comparison, commands: tuple[str, ...] = ()
) -> str:
    """The page of a comparison of at least one drop as HTML; `commands`: as of `report_page`."""
    named = [
        f"{describe.letter(place)} {one.part_id}"
        for place, one in enumerate(found.found)
    ]
    sizes = [1e3 * np.ptp(part.surface_vertices, axis=0) for part in found.parts]
    return words.template(
        "comparison.html", points=_points, numbered=_pose_numbers
    ).render(
        MOST_ROWS=LIMITS["MOST_ROWS"],
        verdict=_verdict,
        found=found,
        named=named,
        first=found.found[0],
        commands=commands,
        sizes=[" × ".join(f"{x:.4g}" for x in size) for size in sizes],
        centers=[
            " ".join(f"{x + 0.0:.4g}" for x in np.round(1e3 * part.center_of_mass, 4))
            for part in found.parts
        ],
        sections=[_section(found, one) for one in found.variants],
        **{
            kind: [
                (whose, *words.in_words(line))
                for whose, line in describe.name_remarks(found, kind)
            ]
            for kind in ("warnings", "notes")
        },
    )


def _section(
    found: comparison.Comparison, one: comparison.VariantComparison
) -> dict[str, Any]:
    """What the page says of the first variant beside another one."""
    shown = one.poses[:MOST_SHOWN]
    sides = found.found[0], found.found[one.second]
    pairs = [
        [
            side.by_index[some[0]] if some else None
            for side, some in zip(sides, pose.poses, strict=True)
        ]
        for pose in shown
    ]
    radius = max(side.radius for side in sides)
    pictures = poses.pictures_beside(
        (found.parts[0], found.parts[one.second]),
        one.correspondence.turn,
        pairs,
        radius,
    )
    return {
        "other": describe.letter(one.second),
        "comparison": one,
        "verdict": describe.describe_verdict(found, one),
        "matching": describe.describe_matching(one),
        "cards": [
            (
                pose,
                [
                    None
                    if each is None
                    else figures.address("png", figures.png_bytes(each))
                    for each in pair
                ],
            )
            for pose, pair in zip(shown, pictures, strict=True)
        ],
    }


def _verdict(pose: comparison.PoseComparison) -> str:
    """What is to be read of a pose at a glance."""
    if (pose.share.in_model, pose.share.on_plate) == (
        comparison.DIFFERENCE_SHOWN,
        comparison.NO_DIFFERENCE,
    ):
        return "shown in the model only"
    return pose.share.in_model


def _points(fraction: float) -> str:
    """A signed difference in points."""
    if math.isnan(fraction):
        return "\N{EN DASH}"
    rounded = round(100.0 * fraction, 1)
    return f"{rounded:+.1f}".replace("-", "\N{MINUS SIGN}") if rounded else "0.0"


def _pose_numbers(poses: tuple[int, ...]) -> str:
    named = name_poses(poses).replace(" ", words.SPACE, 1).replace("-", words.RANGE)
    return named if poses else "no partner"
