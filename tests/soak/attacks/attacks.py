"""Each attack: what is done, how often, and what must not come of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from tests.ros.harness.cell import QuickClient
from tests.ros.harness.slow import slivers
from tests.ros.restart.test_kill_node import Killings

from . import ending, fairness, memory, restarts
from .bodies import fine_box, smooth_body
from .cell import MEGABYTE, percentile

SIZE = 2_000_000
"""Bytes of a large mesh, in miniature."""

KILLS = 10

LATER = {"known": 50.0, "small": 100.0}
"""Milliseconds by which a known part's and a small mesh's median answer may come later."""


class Outcome(NamedTuple):
    """What came of an attack.

    Attributes
    ----------
    trials : int
    broken : list of str
        Each promise that was not kept, with what was seen.
    measured : str
        In words, with units.
    """

    trials: int
    broken: list[str]
    measured: str


def judge(trials: int, measured: str, **kept: bool) -> Outcome:
    """An outcome from promises and whether each was kept."""
    return Outcome(trials, [f"{name.replace('_', ' ')}: {measured}" for name, good in kept.items()
                            if not good], measured)


def restart_with_nothing_new(domain: int, folder: Path) -> Outcome:
    """Known large parts, and the node started again and again."""
    meshes, before, starts = restarts.grow(domain, folder, 4, SIZE, 4, max_parts=3)
    added = (starts[-1].disk - before) / len(starts)
    grown = starts[-1].peak - starts[0].peak
    return judge(
        len(starts), f"{added / meshes:.2%} of the meshes' size added a start, peak memory "
        f"{starts[0].peak / MEGABYTE:.0f} and {starts[-1].peak / MEGABYTE:.0f} MiB",
        disk_is_flat=added < 0.01 * meshes, memory_is_flat=grown < 0.1 * starts[0].peak,
        the_same_parts_are_there=all(one.parts == starts[0].parts for one in starts))


def restart_on_a_copied_run(domain: int, folder: Path) -> Outcome:
    """A part forgotten since, and a copy of the run that knew it."""
    with restarts.attacked(domain, folder) as (_, client):
        restarts.publish_parts(client, 2, SIZE)
    with restarts.attacked(domain, folder) as (_, client):
        restarts.until(lambda: len(restarts.part_ids(client)) == 2, "the parts")
        client.good("forget_part", part_id="part_000")
    restarts.copy_oldest(folder)
    starts = restarts.restart(domain, folder, 2, 1)
    return judge(len(starts), f"{starts[-1].parts} known",
                 what_was_forgotten_stays_away=all(one.parts == ["part_001"] for one in starts))


def many_large_parts(domain: int, folder: Path) -> Outcome:
    """More parts than `max_part_bytes` holds, and as many again."""
    bound, half = 12 * SIZE, 12
    grown, later, known = memory.fill(domain, folder, half, SIZE, max_part_bytes=bound)
    return judge(2 * half, f"{grown / MEGABYTE:.0f} MiB more for a bound of "
                 f"{bound / MEGABYTE:.0f}, then {later / MEGABYTE:.0f}, {len(known)} parts known",
                 bounded=grown < 5 * bound, no_more_comes=later < bound,
                 some_are_known=len(known) > 0)


def refused_goals(domain: int, folder: Path) -> Outcome:
    """Goals of the action that are refused, each with a large mesh."""
    goals = 30
    grown = memory.refuse_goals(domain, folder, goals, SIZE)
    return judge(goals, f"{grown / MEGABYTE:.0f} MiB more after {goals * SIZE / MEGABYTE:.0f} MiB "
                 f"of meshes", meshes_are_let_go=grown < 0.3 * goals * SIZE)


def waiting_requests(domain: int, folder: Path) -> Outcome:
    """Estimates of large new meshes, asked for all at once."""
    requests = 40
    grown, answers = memory.wait_in_line(domain, folder, requests, SIZE, max_mesh_bytes=SIZE)
    refused = [one.message for one in answers if not one.success]
    return judge(requests, f"{grown / MEGABYTE:.0f} MiB more at most, {len(refused)} refused",
                 bounded=grown < 40 * SIZE, refusals_say_why=all(
                     "expected" in message for message in refused))


def _beside(domain: int, folder: Path, trouble: Callable[..., object], surface: object,
            seconds: float) -> Outcome:
    """How much later others are answered beside some trouble."""
    found = fairness.latencies(domain, folder, trouble, surface, seconds)
    kept, words = {}, []
    for name, (alone, beside) in found.items():
        later = percentile(beside, 0.5) - percentile(alone, 0.5)
        kept[f"a_{name}_part_is_answered"] = later < LATER[name]
        words.append(f"{name} {percentile(alone, 0.5):.0f} ms alone, beside "
                     f"{percentile(beside, 0.5):.0f} (p99 {percentile(beside, 0.99):.0f})")
    return judge(sum(len(beside) for _, beside in found.values()), "; ".join(words), **kept)


def a_million_triangles(domain: int, folder: Path) -> Outcome:
    """A mesh that is only large."""
    return _beside(domain, folder, fairness.mesh_under_check, fine_box(1e6), 4.0)


def a_smooth_mesh(domain: int, folder: Path) -> Outcome:
    """A mesh with a hundred thousand corners on its hull."""
    return _beside(domain, folder, fairness.mesh_under_check, smooth_body(2e5), 4.0)


def a_mesh_of_slivers(domain: int, folder: Path) -> Outcome:
    """Needles that lie across each other."""
    return _beside(domain, folder, fairness.mesh_under_check, slivers(10_000), 4.0)


def a_thousand_requests(domain: int, folder: Path) -> Outcome:
    """A thousand estimates asked for at once by somebody else."""
    return _beside(domain, folder, fairness.queued_requests, None, 6.0)


def a_client_that_cannot_hear(domain: int, folder: Path) -> Outcome:
    """Twenty requests a second whose answers cannot be delivered."""
    return _beside(domain, folder, fairness.deaf_client, None, 6.0)


def a_disk_that_fills(domain: int, folder: Path) -> Outcome:
    """Fifty new meshes of 30 kB a second, of one part."""
    bound = 3_000_000
    most, end, sent, deleted = ending.fill_disk(
        domain, folder, fine_box(1200), 15.0, 50.0, max_log_bytes=bound)
    return judge(sent, f"{most / 1e6:.1f} MB at most for a bound of {bound / 1e6:.1f}, "
                 f"{end / 1e6:.1f} in the end, {deleted} files deleted",
                 the_bound_is_reached=deleted > 0, the_bound_holds_in_the_end=end <= bound,
                 more_is_soon_gone=most <= 1.25 * bound)


def a_flood_of_counts(domain: int, folder: Path) -> Outcome:
    """Four thousand camera counts, two thousand a second."""
    sent = 4000
    kept, told = ending.flood_counts(domain, folder, sent, 2000.0)
    lost = int(told.get("counts lost", 0))
    return judge(sent, f"{kept} recorded, {lost} told as lost",
                 each_is_recorded_or_told=kept + lost == sent)


def a_signal_during_an_estimate(domain: int, folder: Path) -> Outcome:
    """SIGTERM while a mesh is estimated that takes long."""
    status, seconds, answer, log = ending.end_while_estimating(
        domain, folder, smooth_body(3e5))
    return judge(1, f"exit status {status} after {seconds:.1f} s, "
                 f"{'answered' if answer else 'no answer'}", it_ends_well=status == 0,
                 it_ends_soon=seconds < 4.0, the_client_is_answered=answer is not None,
                 no_traceback="Traceback" not in log)


def simulated_time_stands_still(domain: int, folder: Path) -> Outcome:
    """`use_sim_time` and nobody who publishes /clock."""
    stamp = ending.simulated_time(domain, folder)
    return judge(1, f"answered with the stamp {stamp.sec} s", answered=stamp.sec == 0)


def kills(domain: int, folder: Path) -> Outcome:
    """kill -9 at any moment, and what clients had been told looked for in the bags."""
    killings = Killings(folder, lambda: QuickClient(domain, "/killed/pose_stats"), seed=1)
    broken = []
    for number in range(KILLS):
        try:
            killings.live()
            killings.told.assert_in(killings.recorded())
        except AssertionError as error:
            broken.append(f"kill {number}: {str(error)[:200]}")
    told = len(killings.told.answers) + len(killings.told.accepted) + len(killings.told.ends)
    return Outcome(KILLS, broken, f"{told} answers, acceptances and ends looked for")


ATTACKS: dict[str, Callable[[int, Path], Outcome]] = {
    one.__name__.replace("_", " "): one for one in (
        restart_with_nothing_new, restart_on_a_copied_run, many_large_parts, refused_goals,
        waiting_requests, a_million_triangles, a_smooth_mesh, a_mesh_of_slivers,
        a_thousand_requests, a_client_that_cannot_hear, a_disk_that_fills, a_flood_of_counts,
        a_signal_during_an_estimate, simulated_time_stands_still, kills)}
