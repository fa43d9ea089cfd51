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

"""The tables of docs/measured/design.md: told and estimated gains beside drops."""

import math
import sys
from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np

from lab.frame.page import Page
from lab.frame.results import Row, Section, Target
from ros_pose_stats.core.records import Array
from ros_pose_stats.tools.design.sensitivity import STEP

from .cases import DEMO, Case, all_parts, make_case
from .gains import Gain, measure_gains
from .slopes import Slope, measure_slopes

EACH = 2
"""Parts of each family."""

JUDGING_DROPS = 20_000
"""Drops of each part that judge what `sensitivity` says of a step. Fewer would be off
by more than what they judge."""

QUICK_PARTS = 3  # of the demo parts, the first ones; what rolls takes long

NEAR = 0.015
NEAR_SHARE = 27 / 28
"""A step is known to 1.5 points, but for a few in a hundred."""

KINDS = {"centre": "centre of mass", "stretch": "stretching", "face": "resting face"}

PAGE = Page(
    "design.md",
    """# How far gains of changes are right

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


GAINS = (
    "{} checked steps of {} parts: what `sensitivity` says that they gain, beside {} "
    "other drops of each part. *Near*: within 1.5 points of these. *Recommended*: a "
    "gain beyond chance; *of these losing*: the other drops show a loss beyond two "
    "standard errors. *In the interval*: the other drops' own error is part of it."
)


def _cases(is_quick: bool) -> Iterator[Case]:
    """Some parts of each family and the demo parts, or a few of these."""
    parts = islice(all_parts(0), QUICK_PARTS) if is_quick else all_parts(EACH)
    for family, number in parts:
        case = make_case(family, number)
        features = len(case.space.features)
        print(f"{family} {number}: {features} features", file=sys.stderr, flush=True)
        yield case


def gains_section(is_quick: bool) -> Section:
    """Ask about parts of all families, or the demo parts, and judge the answers."""
    by_part = [measure_gains(case, JUDGING_DROPS) for case in _cases(is_quick)]
    gains = [gain for part in by_part for gain in part]
    of_demo_parts = [gain for gain in gains if gain.family == DEMO]
    rows = [_gains_row("all", gains), _gains_row(DEMO, of_demo_parts)]
    about = GAINS.format(len(gains), len(by_part), JUDGING_DROPS)
    return Section("gains", "Gains by drops", about, tuple(rows))


def _gains_row(name: str, gains: Sequence[Gain]) -> Row:
    told = np.array([gain.value for gain in gains])
    estimated = np.array([gain.estimated for gain in gains])
    measured = np.array([gain.measured for gain in gains])
    recommended = [gain for gain in gains if gain.is_recommended]
    near = 100.0 * float((np.abs(told - measured) <= NEAR).mean())
    losing = sum(gain.loses for gain in recommended)
    near_estimates = 100.0 * float((np.abs(estimated - measured) <= NEAR).mean())
    held = [
        gain.low - 2.0 * gain.measured_error
        <= gain.measured
        <= gain.high + 2.0 * gain.measured_error
        for gain in gains
    ]
    return Row(
        name,
        {
            "steps": len(gains),
            "near, %": near,
            "estimates near, %": near_estimates,
            "recommended": len(recommended),
            "of these losing": losing,
            "in the interval, %": 100.0 * float(np.mean(held)),
            "drops, median": int(np.median([gain.drops for gain in gains])),
        },
        (
            Target("steps near, %", near, 100.0 * NEAR_SHARE, at_least=True),
            Target("recommended steps that lose", losing, 1),
        ),
    )


def derivatives_section(is_quick: bool) -> Section:
    """Measure some parts of each family, or the demo parts, one after the other."""
    slopes: list[Slope] = []
    for case in _cases(is_quick):
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
