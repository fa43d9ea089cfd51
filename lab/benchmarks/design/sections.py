"""The table of docs/measured/design.md: estimated changes beside dropped ones."""

import math
import sys
from collections.abc import Sequence

import numpy as np

from lab.frame.page import Page
from lab.frame.results import Row, Section
from ros_pose_stats.core.records import Array
from ros_pose_stats.tools.design.sensitivity import STEP

from .cases import all_parts, make_case
from .slopes import Slope, measure_slopes

EACH = 2
"""Parts of each family."""

KINDS = {"centre": "centre of mass", "stretch": "stretching", "face": "resting face"}

PAGE = Page(
    "design.md",
    """# How far estimated effects of changes are right

Written by `python -m lab.benchmarks.design --write`; edits here are lost. What is
changed and how: [design](../design.md). Restitution 0.3, 0.5 or 0.7, 20 radii; the
wanted poses are one group of poses, drawn at random from those of 10 to 90 %.
""",
    ("design",),
)

ABOUT = (
    "{} parts of all families, prisms with a hidden insert and the demo parts; of each "
    "some features drawn at random, changed by {:g} % of the radius to both sides, and "
    "dropped before and after from the same starts. *Clear* are the cases whose "
    "estimated and measured changes both exceed their errors. *Slope* is that of the "
    "estimated on the measured change, with the noise of the drops taken off; *size* "
    "the root mean square change, *apart* that of the difference between estimate and "
    "drops, noise taken off. The interval is that of both errors, the estimate's and "
    "the drops'."
)


def derivatives() -> Section:
    """Measure some parts of each family one after the other, and make the table."""
    slopes: list[Slope] = []
    for family, number in all_parts(EACH):
        case = make_case(family, number)
        features = len(case.space.features)
        print(f"{family} {number}: {features} features", file=sys.stderr, flush=True)
        slopes += measure_slopes(case)
    return slopes_section(slopes)


def slopes_section(slopes: Sequence[Slope]) -> Section:
    """A row for all cases, and one for those of each kind."""
    parts = len({slope[:2] for slope in slopes})
    rows = [_row("all", slopes)]
    for kind, title in KINDS.items():
        of_kind = [slope for slope in slopes if slope.kind == kind]
        if of_kind:
            rows.append(_row(title, of_kind))
    about = ABOUT.format(parts, 100.0 * STEP)
    return Section("derivatives", "Derivatives", about, tuple(rows))


def _row(name: str, slopes: Sequence[Slope]) -> Row:
    estimated, error, measured, noise = np.array(
        [slope[3:7] for slope in slopes], dtype=np.float64
    ).T
    is_clear = (np.abs(estimated) > error) & (np.abs(measured) > noise)
    is_right = (np.sign(estimated) == np.sign(measured))[is_clear]
    power = float((measured**2 - noise**2).sum())
    differences = (measured - estimated) ** 2 - noise**2
    is_held = np.abs(measured - estimated) <= 1.645 * np.hypot(error, noise)
    slope = float((estimated * measured).sum()) / power
    return Row(
        name,
        {
            "cases": len(slopes),
            "clear": int(is_clear.sum()),
            "sign right, %": 100.0 * float(is_right.mean()) if is_right.size else "",
            "slope": f"{slope:.2f} ± {_slope_error(estimated, measured, noise):.2f}",
            "size, points": 100.0 * math.sqrt(max(0.0, power / len(slopes))),
            "apart, points": 100.0 * math.sqrt(max(0.0, float(differences.mean()))),
            "in the 90 % interval, %": 100.0 * float(is_held.mean()),
        },
    )


def _slope_error(estimated: Array, measured: Array, noise: Array) -> float:
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
