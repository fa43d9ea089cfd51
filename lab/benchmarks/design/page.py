"""The page docs/measured/design.md from what the study found."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lab.frame.documents import markdown_table, points
from ros_pose_stats.tools.design.sensitivity import STEP

from .slopes import Slope

KINDS = {"centre": "centre of mass", "stretch": "stretching", "face": "resting face"}


def summarise_slopes(slopes: Sequence[Slope]) -> dict[str, float]:
    """Counts, signs and slopes of some cases.

    `slope` is that of the estimated on the measured changes through the origin, with
    the noise of the drops taken off; `held` the share of the cases in the 90 % interval
    of both errors.
    """
    estimated, error, measured, noise = np.array(
        [slope[3:7] for slope in slopes], dtype=np.float64
    ).T
    clear = (np.abs(estimated) > error) & (np.abs(measured) > noise)
    right = np.sign(estimated) == np.sign(measured)
    power = float((measured**2 - noise**2).sum())
    differences = (measured - estimated) ** 2 - noise**2
    return {
        "cases": len(slopes),
        "parts": len({slope[:2] for slope in slopes}),
        "clear": int(clear.sum()),
        "right": float(right[clear].mean()) if clear.any() else math.nan,
        "slope": float((estimated * measured).sum()) / power,
        "slope_error": _slope_error(estimated, measured, noise),
        "size": math.sqrt(max(0.0, power / len(slopes))),
        "apart": math.sqrt(max(0.0, float(differences.mean()))),
        "held": float(
            (np.abs(measured - estimated) <= 1.645 * np.hypot(error, noise)).mean()
        ),
    }


def _slope_error(
    estimated: NDArray[np.float64],
    measured: NDArray[np.float64],
    noise: NDArray[np.float64],
) -> float:
    """By the bootstrap over the cases."""
    draw = np.random.default_rng(0)
    slopes = []
    for _ in range(400):
        resample = draw.integers(len(estimated), size=len(estimated))
        p = estimated[resample]
        m = measured[resample]
        e = noise[resample]
        slopes.append((p * m).sum() / (m * m - e * e).sum())
    return float(np.std(slopes))


def slopes_table(slopes: Sequence[Slope]) -> str:
    """Markdown: all cases, then those of each kind."""
    rows = []
    for name, of_kind in (
        ("all", list(slopes)),
        *(
            (label, [slope for slope in slopes if slope.kind == kind])
            for kind, label in KINDS.items()
        ),
    ):
        if not of_kind:
            continue
        summary = summarise_slopes(of_kind)
        rows.append(
            (
                name,
                f"{summary['cases']}",
                f"{summary['clear']}",
                points(summary["right"], 0),
                f"{summary['slope']:.2f} ± {summary['slope_error']:.2f}",
                points(summary["size"]),
                points(summary["apart"]),
                points(summary["held"], 0),
            )
        )
    return markdown_table(
        (
            "change",
            "cases",
            "clear",
            "sign right, %",
            "slope",
            "size, points",
            "apart, points",
            "in the 90 % interval, %",
        ),
        rows,
    )


def page(slopes: Sequence[Slope]) -> str:
    """The whole page."""
    summary = summarise_slopes(slopes)
    parts = summary["parts"]
    return f"""# How far estimated effects of changes are right

Written by `python -m lab.benchmarks.design --write`; edits here are lost. What is
changed and how: [design](../design.md). Restitution 0.3, 0.5 or 0.7, 20 radii; the
wanted poses are one group of poses, drawn at random from those of 10 to 90 %.

## Derivatives

{parts} parts of all families, prisms with a hidden insert and the demo parts; of each
some features drawn at random, changed by {100.0 * STEP:g} % of the radius to both
sides, and dropped before and after from the same starts. *Clear* are the cases whose
estimated and measured changes both exceed their errors. *Slope* is that of the
estimated on the measured change, with the noise of the drops taken off; *size* the root
mean square change, *apart* that of the difference between estimate and drops, noise
taken off. The interval is that of both errors, the estimate's and the drops'.

{slopes_table(slopes)}
"""
