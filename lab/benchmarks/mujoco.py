"""Every time step of MuJoCo on three bodies: `python -m lab.benchmarks.mujoco [--drops N]`."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence

from ros_pose_stats import part_from_mesh
from study.mujoco_drops import Plate, Setting, drop_in_mujoco, setting

from . import bodies

STEPS = (3, 4, 5, 6, 8, 10, 13, 16, 20, 30)
"""Time steps in the duration of a contact, the longest step first."""
DEPTHS = (0.7, 1.4)
"""Accepted median depth of first impacts, as a fraction of the wanted one."""
MEDIAN = 0.1
TYPICAL = 0.05
"""Accepted relative error of the median restitution, and median absolute error of restitution."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Print depth, restitution and rate of every time step; `*` marks the chosen one."""
    parser = argparse.ArgumentParser(prog="lab.benchmarks.mujoco", description=__doc__)
    parser.add_argument("--drops", type=int, default=20)
    drops = parser.parse_args(arguments).drops
    print(
        "vertices   rho steps      step   depth  measured rho (10 % to 90 %)  drops/s  to rest"
    )
    for vertices in (6, 10, 23):
        plate = Plate(part_from_mesh(*bodies.random_polyhedron(vertices, 0)[1:]))
        for restitution in (0.2, 0.5, 0.8):
            mark = "*"
            for found in settings(plate, restitution, 0.01):
                right = is_accepted(found, restitution, 0.01)
                usable = abs(found.restitution / restitution - 1.0) <= MEDIAN
                rates = [
                    drops / drop_in_mujoco(plate, found, drops, 1, to_rest).seconds
                    for to_rest in (False, True)
                    if usable
                ] or [math.nan] * 2
                print(
                    f"{vertices:8}{restitution:6.1f}{found.steps:6}{mark if right else ' '}"
                    f"{found.step:9.2e}{found.penetration:8.4f}"
                    f"{found.restitution:10.3f} ({found.low:.3f} to {found.high:.3f})"
                    f"{rates[0]:14.1f}{rates[1]:9.1f}",
                    flush=True,
                )
                mark = " " if right else mark


def settings(plate: Plate, restitution: float, penetration: float) -> Iterator[Setting]:
    """A setting for each number of steps in a contact."""
    for steps in STEPS:
        yield setting(plate, restitution, penetration, steps)


def is_accepted(found: Setting, restitution: float, penetration: float) -> bool:
    """Whether depth and restitution of a setting are right within the limits."""
    return (
        DEPTHS[0] <= found.penetration / penetration <= DEPTHS[1]
        and abs(found.restitution / restitution - 1.0) <= MEDIAN
        and found.typical <= TYPICAL
    )


def choose_setting(plate: Plate, restitution: float, penetration: float) -> Setting:
    """Longest time step at which depth and restitution of first impacts are right."""
    for found in settings(plate, restitution, penetration):
        if is_accepted(found, restitution, penetration):
            return found
    raise RuntimeError(f"no time step gives MuJoCo a restitution of {restitution:g}")


if __name__ == "__main__":
    main()
