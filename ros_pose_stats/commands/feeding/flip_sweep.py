"""`flips PART --sweep`: the kick that feeds fastest."""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ...errors import RequestError
from ..drop_runs import load_part_and_kernels
from ..progress_bar import ProgressBar
from ..running import INTERRUPTED, output_file, print_json, stop_on_interrupt

if TYPE_CHECKING:
    from ...planning.kick_sweep import KickSweep
    from ...records import PoseStatistics
    from ...statistics.feeding import Feeding


def sweep(options: argparse.Namespace) -> int:
    """Drop, kick from every height, print, and draw where that is wanted."""
    if options.wanted is None:
        raise RequestError("--wanted with --sweep", "--sweep alone",
                           "name the poses that are accepted; `ros_pose_stats estimate` lists "
                           "them")
    picture = None if options.png is None else output_file(options.png, (".png",))
    part = load_part_and_kernels(options)
    from ...planning.kick_sweep import SWEEP_FLIPS, sweep_kicks
    from ...simulation.flips import check_kick
    from ...simulation.simulate import simulate
    from ...statistics.feeding import check_cycle_time, check_rate
    from ...statistics.pose_groups import warn_of_alike

    for height in options.sweep:
        check_kick(height)
    check_rate(options.rate)
    check_cycle_time(options.cycle_time)
    with stop_on_interrupt() as interrupted, ProgressBar(sys.stderr) as bar:
        fresh = simulate(part, options.drops, options.restitution, options.seed,
                         options.drop_height, workers=options.workers, on_progress=bar.show,
                         should_stop=interrupted, cluster_tolerance=options.cluster_tolerance,
                         round_sides=options.round_sides)
        fresh = replace(fresh, warnings=(*fresh.warnings, *warn_of_alike(fresh, options.wanted)))
        found = None if interrupted() else sweep_kicks(
            part, fresh, options.wanted, options.rate, options.cycle_time, options.sweep,
            SWEEP_FLIPS if options.flips is None else options.flips, fresh.seed, options.workers,
            lambda done, total: bar.draw(done / total, f"{done} of {total} flips"), interrupted)
    stopped = interrupted()
    if options.json:
        print_json({**_plain(fresh, found), **({"interrupted": True} if stopped else {})})
    else:
        print("\n".join(_table(fresh, found) if found and found.kicks else
                        [f"{fresh.part_id}: {fresh.scene}"]))
        if stopped:
            print(f"interrupted after {len(found.kicks) if found else 0} kick heights")
    if picture is not None and found is not None and found.kicks:
        from ...files import write_file
        from ...plots.files import figure_png
        from ...plots.kicks import kick_figure

        write_file(picture, figure_png(kick_figure(found)))
    return INTERRUPTED if stopped else 0


def _plain(fresh: PoseStatistics, found: KickSweep | None) -> dict[str, Any]:
    """The sweep as plain values, as far as it came."""
    names = ("part_id", "part_digest", "radius", "restitution", "drop_height",
             "cluster_tolerance", "round_sides", "drops", "seed", "version")
    plain = {**{name: getattr(fresh, name) for name in names}, "warnings": list(fresh.warnings)}
    if found is None:
        return plain
    return {**plain, "wanted": list(found.wanted), "rate": found.rate,
            "cycle_time": found.cycle_time, "dropped_again": write_feeding(found.afresh),
            "kicks": [{"kick_height": one.kick_height, "flips": one.flips.flips,
                       "feeding": write_feeding(one.feeding)} for one in found.kicks],
            "best": found.best.kick_height if found.kicks else None,
            "near_best": [one.kick_height for one in found.near_best] if found.kicks else []}


def _table(fresh: PoseStatistics, found: KickSweep) -> list[str]:
    from ...text import Column, columns, listed, millimetres

    best, near = found.best, {one.kick_height for one in found.near_best}
    heads = [Column("kick height", "mm"), Column("accepted a minute"), Column("flips a part"),
             Column("", left=True)]
    rows = [[millimetres(one.kick_height), show_bounded(one.feeding.per_minute),
             show_bounded(one.feeding.flips),
             "fastest" if one is best else "as fast" if one.kick_height in near else ""]
            for one in found.kicks]
    return [f"{fresh.part_id}: {fresh.scene}; flips out of each pose: "
            f"{best.flips.flips // len(fresh.poses)} at each height, seed {fresh.seed}",
            f"wanted: {listed(found.wanted)}; {found.rate:g} parts dropped a minute, "
            f"{found.cycle_time:g} s from kick to kick", "", *columns(heads, rows),
            f"dropped again: {show_bounded(found.afresh.per_minute)} accepted a minute",
            "in brackets: 90 % intervals, of the model alone; as fast: not told apart from the "
            "fastest", *(["", *fresh.warnings] if fresh.warnings else [])]


def write_feeding(found: Feeding) -> dict[str, dict[str, float | None]]:
    """What a feeder gets as plain values; null stands for what is not known or has no bound."""
    return {key: {name: number if math.isfinite(number) else None
                  for name, number in one._asdict().items()}
            for key, one in found._asdict().items()}


def show_bounded(number: tuple[float, float, float]) -> str:
    """A number and its bounds."""
    value, low, high = number
    if math.isnan(low) or math.isnan(high):
        return "no bound" if math.isinf(value) else f"{value:.3g}"
    return f"{value:.3g} ({low:.3g} to {high:.3g})"
