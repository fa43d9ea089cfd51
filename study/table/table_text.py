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

"""The table of one dataset as Markdown."""

from collections.abc import Iterator

from lab.frame.documents import markdown_table, points, with_error

from .. import paper
from .table_results import Range, Row, TableResults


def table_text(results: TableResults) -> str:
    """Sections with a line of explanation and a table each."""
    return "\n\n".join(_sections(results))


def _sections(results: TableResults) -> Iterator[str]:
    spec = results.spec
    yield (
        f"### Shift {spec.shift:g} ({spec.shift_moment}), {spec.bodies} bodies, "
        f"{spec.drops} drops of each, {spec.scene}\n\n"
        "Errors in points, noise removed, ± standard error (bootstrap over bodies). "
        "`largest` is the largest deviation from simulation, noise included: the "
        f"paper's in {paper.DROPS} drops, here in the first {results.first} and in "
        "all. `hybrid` was given the first drops and is held against the others."
    )
    yield _estimators(results)
    yield _noise(results)
    yield "The bodies beside the paper's:\n\n" + _bodies(results)
    if results.outliers:
        yield (
            "The largest deviations of the combined estimator after "
            f"{results.first} drops, and after fresh ones, in points (section 4.F):\n\n"
            + _outliers(results)
        )


def _estimators(results: TableResults) -> str:
    restitutions = results.spec.restitutions
    head = [
        "estimator",
        "paper",
        "pooled",
        *(f"ρ = {restitution:g}" for restitution in restitutions),
        "largest, paper",
        f"largest, {results.first}",
        f"largest, {results.spec.drops}",
    ]
    rows = [*results.rows, *([results.combined] if results.combined else [])]
    return markdown_table(head, [_cells(row) for row in rows])


def _cells(row: Row) -> list[str]:
    """A row beside the paper's figures, where it has some."""
    largest = paper.LARGEST.get(row.name)
    printed = paper.ERRORS.get(row.name)
    return [
        row.title,
        "" if printed is None else points(printed),
        *(
            with_error(accuracy.error, accuracy.standard_error)
            for accuracy in (row.pooled, *row.by_restitution.values())
        ),
        "" if largest is None else points(largest),
        "" if row.first is None else points(row.first.largest),
        points(row.pooled.largest),
    ]


def _noise(results: TableResults) -> str:
    single = ", ".join(
        f"{with_error(*noise[:2])} at {restitution:g}"
        for restitution, noise in results.noise.items()
    )
    lines = [
        f"Noise σ(p, s) of {paper.DROPS} drops: "
        f"{with_error(*results.pooled_noise[:2])} points (paper "
        f"{points(paper.NOISE, 2)}); {single}."
    ]
    if results.sensitivity is not None:
        low = min(results.spec.restitutions)
        high = max(results.spec.restitutions)
        restitution = results.sensitivity
        lines.append(
            f"Sensitivity σ(p, p) between restitution {low:g} and {high:g}: "
            f"{with_error(restitution.error, restitution.standard_error)} points "
            f"(paper {points(paper.SENSITIVITY, 2)} between 0.2 and 0.8)."
        )
    return "\n".join(lines)


def _bodies(results: TableResults) -> str:
    shapes = results.shapes
    values = 3 * round(paper.MEAN_POSES * 1057)
    rows = [
        ("N, poses times restitutions", f"{values}", f"{shapes.values}"),
        ("stable poses, mean", f"{paper.MEAN_POSES:.2f}", f"{shapes.mean_poses:.2f}"),
        ("stable poses", _span(paper.POSES), _span(shapes.poses)),
        ("vertices", _span(paper.VERTICES), _span(shapes.vertices)),
        ("faces", _span(paper.FACES), _span(shapes.faces)),
        (
            f"largest probability in {results.first} drops",
            f"{paper.LARGEST_PROBABILITY:.2f}",
            f"{shapes.largest_probability:.2f}",
        ),
        ("bodies drawn anew", "", f"{shapes.redraws}"),
        ("drops that did not settle", "", f"{shapes.unsettled}"),
    ]
    return markdown_table(("", "paper", "here"), rows)


def _outliers(results: TableResults) -> str:
    drop_numbers = [drops for drops, _ in results.outliers[0].again]
    rows = []
    for outlier in results.outliers:
        rows.append(
            (
                f"body {outlier.body}, pose {outlier.pose}",
                f"{outlier.restitution:g}",
                points(abs(outlier.first - outlier.estimate)),
                *(points(abs(share - outlier.estimate)) for _, share in outlier.again),
            )
        )
    for k, (restitution, first, later) in enumerate(paper.OUTLIERS):
        rows.append(
            (
                f"paper's, {k + 1}",
                f"{restitution:g}",
                points(first),
                points(later),
                *([""] * (len(drop_numbers) - 1)),
            )
        )
    return markdown_table(
        ("", "ρ", f"{results.first} drops", *(f"{n} drops" for n in drop_numbers)), rows
    )


def _span(span: Range | tuple[int, int]) -> str:
    return f"{span[0]} to {span[1]}"
