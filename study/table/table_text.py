"""The table of one dataset as Markdown."""

from __future__ import annotations

from collections.abc import Iterator

from lab.frame.documents import markdown_table, plus_minus, points, with_error

from .. import paper
from .table_results import Range, TableResults


def table_text(found: TableResults) -> str:
    """Sections with a line of explanation and a table each."""
    return "\n\n".join(_sections(found))


def _sections(found: TableResults) -> Iterator[str]:
    spec = found.spec
    yield (
        f"### Shift {spec.shift:g} ({spec.shift_moment}), {spec.bodies} bodies, "
        f"{spec.drops} drops of each, {spec.scene}\n\n"
        "Errors in points, noise removed, ± standard error (bootstrap over bodies). `largest` "
        "is the largest deviation from simulation, noise included: the paper's in "
        f"{paper.DROPS} drops, here in the first {found.first} and in all. `hybrid` was given "
        "the first drops and is held against the others."
    )
    yield _estimators(found)
    yield _noise(found)
    yield "The bodies beside the paper's:\n\n" + _bodies(found)
    if found.refits:
        yield (
            "Fitted anew to this dataset (± standard error); errors in points with the "
            "published numbers and with the fitted ones:\n\n" + _refits(found)
        )
    if found.calibration:
        yield (
            f"Whether standard errors and 90 % intervals of {found.first} drops fit the "
            f"other {spec.drops - found.first}:\n\n" + _calibration(found)
        )
    if found.outliers:
        yield (
            "The largest deviations of the combined estimator after "
            f"{found.first} drops, and after fresh ones, in points (section 4.F):\n\n"
            + _outliers(found)
        )


def _estimators(found: TableResults) -> str:
    restitutions = found.spec.restitutions
    head = [
        "estimator",
        "paper",
        "pooled",
        *(f"ρ = {one:g}" for one in restitutions),
        "largest, paper",
        f"largest, {found.first}",
        f"largest, {found.spec.drops}",
    ]
    rows = []
    for row in found.rows:
        largest = paper.LARGEST.get(row.name)
        printed = paper.ERRORS.get(row.name)
        rows.append(
            [
                row.title,
                "" if printed is None else points(printed),
                with_error(row.pooled.error, row.pooled.standard_error),
                *(
                    with_error(one.error, one.standard_error)
                    for one in row.by_restitution.values()
                ),
                "" if largest is None else points(largest),
                points(row.first.largest),
                points(row.pooled.largest),
            ]
        )
    if found.combined is not None:
        both = found.combined
        rows.append(
            [
                both.title,
                "",
                with_error(both.pooled.error, both.pooled.standard_error),
                *(
                    with_error(one.error, one.standard_error)
                    for one in both.by_restitution.values()
                ),
                "",
                "",
                points(both.pooled.largest),
            ]
        )
    return markdown_table(head, rows)


def _noise(found: TableResults) -> str:
    single = ", ".join(
        f"{with_error(*noise[:2])} at {one:g}" for one, noise in found.noise.items()
    )
    lines = [
        f"Noise σ(p, s) of {paper.DROPS} drops: {with_error(*found.pooled_noise[:2])} points "
        f"(paper {points(paper.NOISE, 2)}); {single}."
    ]
    if found.sensitivity is not None:
        low = min(found.spec.restitutions)
        high = max(found.spec.restitutions)
        one = found.sensitivity
        lines.append(
            f"Sensitivity σ(p, p) between restitution {low:g} and {high:g}: "
            f"{with_error(one.error, one.standard_error)} points "
            f"(paper {points(paper.SENSITIVITY, 2)} between 0.2 and 0.8)."
        )
    return "\n".join(lines)


def _bodies(found: TableResults) -> str:
    shapes = found.shapes
    values = 3 * round(paper.MEAN_POSES * 1057)
    rows = [
        ("N, poses times restitutions", f"{values}", f"{shapes.values}"),
        ("stable poses, mean", f"{paper.MEAN_POSES:.2f}", f"{shapes.mean_poses:.2f}"),
        ("stable poses", _span(paper.POSES), _span(shapes.poses)),
        ("vertices", _span(paper.VERTICES), _span(shapes.vertices)),
        ("faces", _span(paper.FACES), _span(shapes.faces)),
        (
            f"largest probability in {found.first} drops",
            f"{paper.LARGEST_PROBABILITY:.2f}",
            f"{shapes.largest_probability:.2f}",
        ),
        ("bodies drawn anew", "", f"{shapes.redraws}"),
        ("drops that did not settle", "", f"{shapes.unsettled}"),
    ]
    return markdown_table(("", "paper", "here"), rows)


def _refits(found: TableResults) -> str:
    rows = []
    for one in found.refits:
        published = ", ".join(f"{value:.3g}" for value in one.published)
        fitted = ", ".join(
            f"{value:.3g} ± {error:.2g}"
            for value, error in zip(one.fitted, one.standard_error, strict=True)
        )
        rows.append(
            (
                one.name,
                published,
                fitted,
                points(one.published_error, 2),
                points(one.error, 2),
            )
        )
    return markdown_table(
        ("", "published", "fitted", "error, published", "error, fitted"), rows
    )


def _calibration(found: TableResults) -> str:
    rows = [
        (
            f"ρ = {restitution:g}",
            plus_minus(one.z_rms, one.z_rms_error, 3),
            f"{one.expected_z_rms:.3f}",
            f"{with_error(one.coverage, one.coverage_error, 1)} %",
            f"{100 * one.expected_coverage:.1f} %",
        )
        for restitution, one in found.calibration.items()
    ]
    return markdown_table(("", "rms of z", "expected", "coverage", "expected"), rows)


def _outliers(found: TableResults) -> str:
    more = [drops for drops, _ in found.outliers[0].again]
    rows = []
    for one in found.outliers:
        rows.append(
            (
                f"body {one.body}, pose {one.pose}",
                f"{one.restitution:g}",
                points(abs(one.first - one.estimate)),
                *(points(abs(told - one.estimate)) for _, told in one.again),
            )
        )
    for k, (restitution, first, again) in enumerate(paper.OUTLIERS):
        rows.append(
            (
                f"paper's, {k + 1}",
                f"{restitution:g}",
                points(first),
                points(again),
                *([""] * (len(more) - 1)),
            )
        )
    return markdown_table(
        ("", "ρ", f"{found.first} drops", *(f"{n} drops" for n in more)), rows
    )


def _span(span: Range | tuple[int, int]) -> str:
    return f"{span[0]} to {span[1]}"
