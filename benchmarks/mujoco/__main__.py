"""Every time step of MuJoCo on three bodies: `python -m benchmarks.mujoco [--drops N]`."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence

from ros_pose_stats import part_from_mesh
from ros_pose_stats.study.mujoco.drops import MEDIAN, accepted, dropped, settings
from ros_pose_stats.study.mujoco.plate import Plate

from .. import bodies


def main(arguments: Sequence[str] | None = None) -> None:
    """Print depth, restitution and rate of every time step; `*` marks the chosen one."""
    parser = argparse.ArgumentParser(prog="benchmarks.mujoco", description=__doc__)
    parser.add_argument("--drops", type=int, default=20)
    drops = parser.parse_args(arguments).drops
    print("vertices   rho steps      step   depth  measured rho (10 % to 90 %)  drops/s  to rest")
    for vertices in (6, 10, 23):
        plate = Plate(part_from_mesh(*bodies.random_polyhedron(vertices, 0)[1:]))
        for restitution in (0.2, 0.5, 0.8):
            mark = "*"
            for setting in settings(plate, restitution, 0.01):
                right = accepted(setting, restitution, 0.01)
                usable = abs(setting.restitution / restitution - 1.0) <= MEDIAN
                rates = [drops / dropped(plate, setting, drops, 1, to_rest).seconds
                         for to_rest in (False, True) if usable] or [math.nan] * 2
                print(f"{vertices:8}{restitution:6.1f}{setting.steps:6}{mark if right else ' '}"
                      f"{setting.step:9.2e}{setting.penetration:8.4f}"
                      f"{setting.restitution:10.3f} ({setting.low:.3f} to {setting.high:.3f})"
                      f"{rates[0]:14.1f}{rates[1]:9.1f}", flush=True)
                mark = " " if right else mark


if __name__ == "__main__":
    main()
