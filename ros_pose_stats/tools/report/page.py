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

"""Pages about a part and its variants: each one HTML file by itself."""

import base64
import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...base.methods import SIMULATION
from ...base.text import name_poses, ranges
from ...core.mesh.decimation import visible_triangles
from ...core.mesh.units import unit_in_words
from ...core.records import Array, Part, PoseStatistics, StablePose
from ...core.records.poses import PoseGroup, lookalikes, single_poses
from ...core.records.statistics import listed_groups
from ...core.statistics import feeding, pose_groups
from ..design import comparison, describe
from ..plots import changes, figures, poses, shares, sphere, splitting
from . import words
from .findings import Findings


def viewer_data(part: Part, poses: Sequence[StablePose], radius: float) -> str:
    """Mesh and poses as JSON, lengths in radii.

    `vertices`: base64 of little-endian float32, three a vertex, about the centre of
    mass; `triangles`: base64 of little-endian uint16, or uint32 where `is_wide`.
    """
    corners = (visible_triangles(part) - part.center_of_mass).reshape(-1, 3)
    # Integers of 16 bits would do for the positions, but not for the normals of thin
    # triangles, which a fine circle in a flat face has many of.
    positions = (corners / radius).astype("<f4") + np.float32(0.0)  # no negative zeros
    vertices, triangles = np.unique(positions, axis=0, return_inverse=True)
    is_wide = len(vertices) > 65_535
    numbers = triangles.reshape(-1).astype("<u4" if is_wide else "<u2")
    return json.dumps(
        {
            "vertices": base64.b64encode(
                np.ascontiguousarray(vertices).tobytes()
            ).decode(),
            "triangles": base64.b64encode(numbers.tobytes()).decode(),
            "wide": is_wide,
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
"""Groups of like poses, or pairs of two variants, with a picture: the most frequent
ones; the table lists more."""

LIMITS = {
    "MOST_ROWS": 60,  # of the tables of all poses
    "MOST_ENDS": splitting.MOST,  # of the splitting graph
    "FITTING": 6,  # ends of it that can be read at a phone's width
    "MOST_TURNED": 14,  # poses in the table of flips
    "BESIDE": 9,  # ends of it that leave room for another figure beside it
}
MOST_FEEDERS = 12
MOST_NAMED = 24
"""Most rows about the feeder, and characters that name the poses of a group."""

ROUNDING = 1e-9  # coordinates of the centre of mass, in radii, that are shown as 0


def report_page(findings: Findings, commands: tuple[str, ...]) -> str:
    """The page of a part as HTML; `commands`: that give the same numbers."""
    part = findings.part
    statistics = findings.answer
    groups = pose_groups.pose_groups(statistics)
    drawn_groups = listed_groups(groups)[:MOST_SHOWN]
    best_poses = [group.first for group in drawn_groups]
    pictures = poses.pose_pictures(part, best_poses, statistics.radius)
    return words.template(
        "page.html",
        named=_name_group,
        numbered=_numbered,
        indices=_list_poses,
        direction=_direction,
    ).render(
        **LIMITS,
        single_poses=single_poses,
        part=part,
        statistics=statistics,
        source=_source(statistics),
        answer_name=_answer_name(statistics),
        estimate=findings.best_estimate,
        feeder=findings.feeder,
        accepted=findings.accepted,
        passes=None
        if findings.accepted is None
        else feeding.passes_of(*findings.accepted),
        cell=findings.cell,
        groups=groups,
        lookalikes={
            group.first.index: lookalikes(group, groups) for group in drawn_groups
        },
        shown=drawn_groups,
        size=np.ptp(part.surface_vertices, axis=0).tolist(),
        unit=unit_in_words(statistics.unit),
        commands=commands,
        center=[
            "0" if abs(x) < ROUNDING * statistics.radius else words.in_millimetres(x)
            for x in part.center_of_mass.tolist()
        ],
        warnings=[
            words.in_words(warning) for warning in findings.warnings if warning.acts
        ],
        cautions=list(map(words.in_words, findings.cautions)),
        notes=[
            words.in_words(warning) for warning in findings.warnings if not warning.acts
        ],
        cards=[
            (group, figures.address("png", figures.png_bytes(picture)))
            for group, picture in zip(drawn_groups, pictures, strict=True)
        ],
        by_method=_by_method(findings, drawn_groups),
        feeders=_feeders(groups) if findings.has_shares else [],
        kicks=_kicks(findings),
        graph=_graph(findings),
        changes=_changes(findings),
        spheres={
            name: figures.svg_address(
                sphere.sphere_figure(findings.sphere, name, findings.graph)
            )
            for name in ("R", "r")
        },
        view=viewer_data(part, best_poses, statistics.radius),
    )


def _source(statistics: PoseStatistics) -> str:
    """What the shares of the page are from, in words."""
    drops = f"{statistics.drops} simulated drops"
    if statistics.method == SIMULATION:
        return drops
    if not statistics.drops:
        return "the best estimate alone"
    return f"the best estimate and {drops}"


def _answer_name(statistics: PoseStatistics) -> str:
    """What the page calls its answer; only one that nobody chose explains itself."""
    return "default answer" if statistics.choice else SIMULATION


def _feeders(groups: Sequence[PoseGroup]) -> list[tuple[PoseGroup, feeding.Bounded]]:
    """Drops of a part where only one group of poses is accepted."""
    return [
        (
            group,
            feeding.passes_of(
                group.probability, group.probability_low, group.probability_high
            ),
        )
        for group in groups[:MOST_FEEDERS]
    ]


def _kicks(findings: Findings) -> str | None:
    """What the feeder gets by its own kick and by others, as a picture."""
    cell = findings.feeder.cell
    if cell is None or findings.cell is None or findings.cell.flips is None:
        return None
    return figures.svg_address(
        shares.kick_figure(findings.part.part_id, cell, findings.cell.plan)
    )


def _by_method(
    findings: Findings, drawn_groups: Sequence[PoseGroup]
) -> list[tuple[PoseGroup, list[tuple[str, PoseGroup]]]]:
    """Each group of poses with the page's answer and that of every estimator."""
    answers = [(_answer_name(findings.answer), findings.answer)]
    answers += [(estimate.method, estimate) for estimate in findings.estimates]
    rows = [
        (name, {group.first.index: group for group in pose_groups.pose_groups(answer)})
        for name, answer in answers
    ]
    return [
        (group, [(name, groups[group.first.index]) for name, groups in rows])
        for group in drawn_groups
    ]


def _graph(findings: Findings) -> dict[str, Any] | None:
    """The splitting graph, the reachable sets, and the ends drawn (Figs. 3C-F)."""
    root = findings.graph
    if root.level is None:
        return None
    return {
        "ends": sum(not branch.parts for branch in splitting.drawn_tree(root).walk()),
        "splitting": figures.svg_address(
            splitting.splitting_figure(root, findings.answer.poses)
        ),
        "reachable": figures.svg_address(
            sphere.reachable_figure(
                findings.sphere, root, sphere.telling_energies(root)
            )
        ),
    }


def _changes(findings: Findings) -> dict[str, Any] | None:
    """What changes of the part do: a picture, and the greatest effects in words."""
    sensitivities = findings.sensitivity
    if sensitivities is None:
        return None
    return {
        "picture": figures.address(
            "png", figures.figure_png(changes.changes_figure(sensitivities))
        ),
        "sensitivities": sensitivities,
        "gain": sensitivities.describe_gain(),
        "goal": sensitivities.describe_goal(),
        "rows": [
            (
                describe.name_step(sensitivities.space, effect.number, effect.step),
                effect,
                check,
            )
            for effect, check in sensitivities.checked
        ],
        "judged": describe.JUDGED,
        "sure": describe.SURE,
    }


def _name_group(group: PoseGroup) -> str:
    return f"pose{'s' if group.size > 1 else ''}{words.SPACE}{_numbered(group)}"


def _numbered(group: PoseGroup) -> str:
    """Numbers of the poses of a group."""
    return _list_poses(group.indices)


def _list_poses(indices: Sequence[int]) -> str:
    """Numbers of poses; the last ones are left out of a long list."""
    text = ranges(indices).replace("-", words.RANGE)
    if len(text) <= MOST_NAMED:
        return text
    return f"{text[:MOST_NAMED].rpartition(',')[0]}, ... ({len(indices)} in all)"


def _direction(direction: Array) -> str:
    return " ".join(f"{x + 0.0:+.3f}" for x in direction.round(3))


def comparison_page(compared: comparison.Comparison, commands: tuple[str, ...]) -> str:
    """The page of a comparison with drops as HTML; `commands`: as of a report."""
    titles = [
        f"{describe.letter(number)} {statistics.part_id}"
        for number, statistics in enumerate(compared.statistics)
    ]
    sizes = [1e3 * np.ptp(part.surface_vertices, axis=0) for part in compared.parts]
    return words.template(
        "comparison.html", points=_points, numbered=_pose_numbers
    ).render(
        MOST_ROWS=LIMITS["MOST_ROWS"],
        verdict=_verdict,
        variants=compared,
        named=titles,
        first=compared.statistics[0],
        commands=commands,
        sizes=[" × ".join(f"{x:.4g}" for x in size) for size in sizes],
        centers=[
            " ".join(f"{x + 0.0:.4g}" for x in np.round(1e3 * part.center_of_mass, 4))
            for part in compared.parts
        ],
        sections=[_section(compared, statistics) for statistics in compared.variants],
        **{
            kind: [
                (variant, *words.in_words(warning))
                for variant, warning in describe.name_warnings(compared)
                if warning.acts is acts
            ]
            for kind, acts in (("warnings", True), ("notes", False))
        },
    )


def _section(
    compared: comparison.Comparison, variant: comparison.VariantComparison
) -> dict[str, Any]:
    """What the page says of the first variant beside another one."""
    pose_comparisons = variant.poses[:MOST_SHOWN]
    sides = compared.statistics[0], compared.statistics[variant.second]
    pairs = [
        [
            side.by_index[numbers[0]] if numbers else None
            for side, numbers in zip(sides, pose.poses, strict=True)
        ]
        for pose in pose_comparisons
    ]
    radius = max(side.radius for side in sides)
    pictures = poses.pictures_beside(
        (compared.parts[0], compared.parts[variant.second]),
        variant.correspondence.turn,
        pairs,
        radius,
    )
    return {
        "other": describe.letter(variant.second),
        "comparison": variant,
        "verdict": describe.describe_verdict(compared, variant),
        "matching": describe.describe_matching(variant),
        "cards": [
            (
                pose,
                [
                    None
                    if picture is None
                    else figures.address("png", figures.png_bytes(picture))
                    for picture in pair
                ],
            )
            for pose, pair in zip(pose_comparisons, pictures, strict=True)
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
    numbers = name_poses(poses).replace(" ", words.SPACE, 1).replace("-", words.RANGE)
    return numbers if poses else "no partner"
