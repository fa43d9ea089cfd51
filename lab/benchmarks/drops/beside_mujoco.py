"""The same drops by MuJoCo, in the same run on the same bodies."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from importlib.metadata import version
from statistics import fmean, median
from typing import NamedTuple

from study.mujoco_drops import Plate, Setting, available, drop_in_mujoco, setting

from ..mujoco import choose_setting
from ..results import Row, Section, Target
from .dropper import RESTITUTIONS, Dropper

TITLE = "Beside MuJoCo"
MISSING = (
    "MuJoCo cannot be imported here, so nothing was compared: `pip install mujoco`."
)
PENETRATION = 0.01
RIGHT_STEPS = 10
"""Steps a contact from which on the restitution of single impacts hardly gets better."""
LEAST = {0.2: 500.0, 0.5: 500.0, 0.8: 300.0}

SETTINGS: dict[str, Callable[[Plate, float], Setting]] = {
    "longest step": lambda plate, wanted: choose_setting(plate, wanted, PENETRATION),
    f"{RIGHT_STEPS} steps a contact": lambda plate, wanted: setting(
        plate, wanted, PENETRATION, RIGHT_STEPS
    ),
}
"""Functions from the plate and restitution to MuJoCo's contact and time step."""


class Race(NamedTuple):
    """Seconds a drop of MuJoCo and of this package, and the setting."""

    setting: Setting
    theirs: float
    ours: float


def beside_mujoco(droppers: Sequence[Dropper], theirs: int, ours: int) -> Section:
    """Two rows for each restitution: MuJoCo's most generous setting, and a good one.

    Parameters
    ----------
    droppers : sequence of Dropper
    theirs, ours : int
        Drops of each body by MuJoCo, and by this package before and again after them.
    """
    if not available():
        return Section(
            "beside_mujoco",
            TITLE,
            MISSING,
            (Row("MuJoCo", {"drops/s": "not installed"}),),
        )
    plates = [Plate(dropper.part) for dropper in droppers]
    rows = []
    for restitution in RESTITUTIONS:
        for name in SETTINGS:
            races = [
                _race(plate, dropper, restitution, name, theirs, ours)
                for plate, dropper in zip(plates, droppers, strict=True)
            ]
            rows.append(_row(restitution, name, races))
    return Section("beside_mujoco", TITLE, _timed(droppers, theirs), tuple(rows))


def _timed(droppers: Sequence[Dropper], theirs: int) -> str:
    corners = " and ".join(str(dropper.vertices) for dropper in droppers)
    return (
        f"MuJoCo {version('mujoco')}, integrator `implicitfast`, frictionless, on bodies of "
        f"{corners} vertices out of those above, {theirs} drops each from 20 radii until the "
        "energy is below the barrier out of the pose; the same end for both, cluster tolerance "
        "0.005. Of MuJoCo only the time inside `mj_step` counts. This package dropped before and "
        "after each of MuJoCo's turns. The contact is aimed at a median depth of "
        f"{PENETRATION:.0%} of the radius in first impacts. `longest step`: the longest time "
        "step whose restitution is right within 10 % in the median and whose typical (median "
        f"absolute) error is at most 0.05, the most that can be said for MuJoCo. "
        f"`{RIGHT_STEPS} steps a contact`: about the longest step from which on a shorter one "
        "no longer makes restitution better impact by impact. Depth and restitution are those "
        "of 64 first impacts, medians over the bodies; `10 %` and `90 %` are quantiles, which "
        "stay apart because a soft contact lasts long enough for a second vertex to touch. "
        "`ratio` is the time of a drop by MuJoCo over that by this package, averaged over the "
        "bodies first; `least` and `most` are those of single bodies."
    )


def _race(
    plate: Plate,
    dropper: Dropper,
    restitution: float,
    name: str,
    theirs: int,
    ours: int,
) -> Race:
    found = SETTINGS[name](plate, restitution)
    rules = dropper.rules(restitution)
    seconds = []
    for seed in (1, 2):
        begin = time.perf_counter()
        dropper.drop(rules, seed, ours)
        seconds.append((time.perf_counter() - begin) / ours)
        if seed == 1:
            mujoco = drop_in_mujoco(plate, found, theirs, 1).seconds / theirs
    return Race(found, mujoco, fmean(seconds))


def _row(restitution: float, name: str, races: Sequence[Race]) -> Row:
    ratios = [race.theirs / race.ours for race in races]
    theirs = fmean(race.theirs for race in races)
    ours = fmean(race.ours for race in races)
    ratio = theirs / ours
    steps = sorted({race.setting.steps for race in races})
    shown = {
        column: median(getattr(race.setting, field) for race in races)
        for column, field in (
            ("time step", "step"),
            ("depth", "penetration"),
            ("measured restitution", "restitution"),
            ("10 %", "low"),
            ("90 %", "high"),
            ("typical error", "typical"),
        )
    }
    return Row(
        f"restitution {restitution}, {name}",
        {
            "steps a contact": f"{steps[0]} to {steps[-1]}"
            if len(steps) > 1
            else steps[0],
            **shown,
            "MuJoCo, drops/s": 1.0 / theirs,
            "drops/s": 1.0 / ours,
            "ratio": ratio,
            "least": min(ratios),
            "most": max(ratios),
        },
        (Target("ratio", ratio, LEAST[restitution], at_least=True),),
    )
