"""Drops a second on one core."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import count
from statistics import fmean

from ..results import Row, Section, Target
from ..timing import Contender, Pace, race
from .dropper import RESTITUTIONS, Dropper

LEAST = {0.2: 12_000.0, 0.5: 8_500.0, 0.8: 4_000.0}
AIM = {0.5: 20_000.0}


def rates(droppers: Sequence[Dropper], drops: int, pace: Pace) -> Section:
    """A row for each restitution; every body is dropped as often."""
    corners = [dropper.vertices for dropper in droppers]
    timed = (
        f"{len(droppers)} random polyhedra as in the paper: hulls of 4 normally distributed "
        "points and as many more as a coin of 0.1 fails before its first success, homogeneous, "
        "at least two stable faces; "
        f"{min(corners)} to {max(corners)} vertices, {fmean(corners):.1f} on average. Cluster "
        "tolerance 0, release 20 radii up. Timed is what one worker does, on one thread and "
        f"warm: making random starting directions and dropping, {drops} drops of each body a "
        "round, others each round. `drops/s` is the median over the rounds, `best` the fastest "
        "one. `steps` are those of the motion between impacts.")
    return Section("drop_rates", "Drops a second on one core", timed,
                   tuple(_rows(droppers, drops, pace)))


def _rows(droppers: Sequence[Dropper], drops: int, pace: Pace) -> list[Row]:
    timings = race([Contender(str(restitution), _caller(droppers, restitution, drops))
                    for restitution in RESTITUTIONS], pace)
    rows = []
    for restitution in RESTITUTIONS:
        number, name = drops * len(droppers), str(restitution)
        efforts = [dropper.effort(dropper.rules(restitution), 0, drops) for dropper in droppers]
        impacts, steps = (fmean(each) for each in zip(*efforts, strict=True))
        rate = number / timings.median(name)
        targets = [Target("drops/s", rate, LEAST[restitution], at_least=True)]
        if restitution in AIM:
            targets.append(Target("aim: drops/s", rate, AIM[restitution], at_least=True))
        rows.append(Row(f"restitution {restitution}", {
            "drops/s": rate, "best": number / min(timings.seconds[name]),
            "impacts a drop": impacts, "steps a drop": steps,
            "µs an impact": 1e6 / rate / impacts,
            "rounds": len(timings.seconds[name]),
        }, tuple(targets)))
    return rows


def _caller(droppers: Sequence[Dropper], restitution: float,
            drops: int) -> Callable[[object], object]:
    seeds = count()
    rules = [dropper.rules(restitution) for dropper in droppers]

    def call(_: object) -> None:
        seed = next(seeds)
        for dropper, rule in zip(droppers, rules, strict=True):
            dropper.drop(rule, seed, drops)

    return call
