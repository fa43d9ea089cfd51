"""The tables of a soak."""

from __future__ import annotations

from statistics import median

from benchmarks.node.spread import spread
from benchmarks.results import Row, Section, Target

from .checks import Recorded
from .tally import Tally

MEGABYTE = 2**20
SHARES = (0.1, 0.25, 0.5, 0.75, 1.0)
MOST_GROWTH = 1.25
"""Times the memory of the longest life's first quarter at its end."""

CALLS = (
    "Calls of one process that drives {lanes} lanes side by side, each of which waits for its "
    "answer before it asks again: parts carried and estimated, simulations by services and "
    "action, some cancelled, parts forgotten, hostile values, and meshes and counts, good and "
    "fuzzed, on the topics. One worker simulates all the time. What the faults below hold up is "
    "in the times; `result` and `goal` include the simulations themselves.")
CHECKS = (
    "Each must be 0. Results are compared with `estimate` and `simulate` of the same arguments "
    "and seed, of cancelled simulations the drops that were done. Acknowledged is what clients "
    "were told without NOT_RECORDED: results, acceptances, ends; all of it must be in the bags, "
    "which were mended first. A part that was estimated at the end of a life must be there with "
    "its mesh when the next one is ready.")
MEMORY = (
    "Resident memory of the longest life, at shares of its time. The node keeps the newest 1000 "
    "jobs with their results, which fill up first.")
COUNTS = "How often what was done, and refusals by the beginning of their reason."


def sections(tally: Tally, found: Recorded, bad: dict[str, int], lanes: int) -> list[Section]:
    """All tables."""
    return [_calls(tally, lanes), _checks(tally, found, bad), _memory(tally),
            _counts(tally, found)]


def _calls(tally: Tally, lanes: int) -> Section:
    rows = [Row(name, spread(seconds)) for name, seconds in sorted(tally.seconds.items())]
    return Section("soak_calls", "Soak: calls", CALLS.format(lanes=lanes), tuple(rows))


def _checks(tally: Tally, found: Recorded, bad: dict[str, int]) -> Section:
    numbers = {
        "estimates unlike the library's": (len(tally.estimates), bad["estimates"]),
        "simulations unlike the library's": (tally.simulated, bad["simulations"]),
        "acknowledged and in no bag": (
            len(tally.answers) + len(tally.accepted) + len(tally.ends), found.lost),
        "anything else that was wrong": (sum(map(len, tally.seconds.values())),
                                         len(tally.wrong))}
    return Section("soak_checks", "Soak: what must not be", CHECKS, tuple(
        Row(name, {"of": number, "found": count}, (Target("found", float(count), 1.0),))
        for name, (number, count) in numbers.items()))


def _memory(tally: Tally) -> Section:
    lives = [sample.life for sample in tally.samples]
    longest = max(set(lives), key=lives.count)
    samples = [sample for sample in tally.samples if sample.life == longest]
    first = median(sample.bytes for sample in samples[:max(1, len(samples) // 4)])
    rows = []
    for share in SHARES:
        at = samples[round(share * (len(samples) - 1))]
        rows.append(Row(f"after {100 * share:.0f} %", {
            "seconds": at.age, "MiB": at.bytes / MEGABYTE, "threads": at.threads}, (
                Target("times the first quarter", at.bytes / first, MOST_GROWTH),)))
    return Section("soak_memory", "Soak: memory", MEMORY, tuple(rows))


def _counts(tally: Tally, found: Recorded) -> Section:
    numbers = {
        "lives of the node": len({sample.life for sample in tally.samples}),
        "calls": sum(map(len, tally.seconds.values())),
        "calls cut off by the end of a life": tally.cut,
        **{f"published: {name}": count for name, count in sorted(tally.messages.items())},
        "meshes and counts refused, of diagnostics": tally.diagnostics["refused"],
        "meshes overrun, of diagnostics": tally.diagnostics["overrun"],
        **{f"fault: {name}": count for name, count in sorted(tally.faults.items())},
        "results told with NOT_RECORDED": tally.unrecorded,
        "bags": found.bags, "messages in them": found.messages,
        **{f"refused: {reason}": count for reason, count in tally.refusals.most_common()}}
    return Section("soak_counts", "Soak: what was done", COUNTS, tuple(
        Row(name.replace("|", "/"), {"number": count}) for name, count in numbers.items()))
