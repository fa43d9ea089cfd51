"""Whether `compare` tells how large a difference is, over many seeds.

    .venv/bin/python -m lab.benchmarks.compared_sizes

Drops end when a difference shows, which flatters it; sizes come from as many fresh ones. Printed
are the mean of the sizes told, where a difference was shown, and that of many more drops.
"""

from __future__ import annotations

import argparse
import os

import numpy as np

from ros_pose_stats import DropScene, compare, part_from_mesh, shift_center
from ros_pose_stats.tools.design.comparison import SHOWN
from ros_pose_stats.tools.design.paired_drops import PairedDrops, paired_difference
from study import shapes

TRUE_DROPS = 100_000
TRUE_SEED = 10**6


def pairs():
    """Variants with a small difference, and the wanted poses of the first."""
    side = 0.016
    die = part_from_mesh(*shapes.box(side, side, side))
    box = part_from_mesh(*shapes.box(0.02, 0.03, 0.012))
    yield (
        "die, 8 % shorter",
        [die, part_from_mesh(*shapes.box(side, side, 0.92 * side))],
        [0, 1],
    )
    yield (
        "box, centre of mass 0.6 mm lower",
        [box, shift_center(box, (0.0, 0.0, -6e-4))],
        [0],
    )
    yield (
        "box, 12 % longer",
        [box, part_from_mesh(*shapes.box(0.0224, 0.03, 0.012))],
        [2, 3],
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="lab.benchmarks.compared_sizes")
    parser.add_argument("--seeds", type=int, default=20, help="default: %(default)s")
    seeds = parser.parse_args().seeds
    for name, parts, wanted in pairs():
        many = PairedDrops(parts, DropScene(), TRUE_SEED, len(os.sched_getaffinity(0)))
        many.drop_until(TRUE_DROPS)
        shown = []
        drops = []
        for seed in range(seeds):
            found = compare(parts, wanted, seed=seed)
            share = found.variants[0].feeder.share
            drops.append(found.drops)
            if share.in_model == SHOWN:
                shown.append(share.difference.value)
        poses = found.variants[0].feeder.poses
        value = paired_difference(*map(many.is_in, (0, 1), poses)).value
        told = float(np.mean(shown)) if shown else float("nan")
        error = float(np.std(shown)) / max(len(shown), 1) ** 0.5
        print(
            f"{name}: true {100.0 * value:+.2f} points ({TRUE_DROPS} drops), shown "
            f"in {len(shown)} of {seeds} seeds after {np.median(drops):.0f} drops, told "
            f"{100.0 * told:+.2f} +- {100.0 * error:.2f}, told / true {told / value:.2f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
