"""What happened in a soak."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from typing import Any, NamedTuple

NOT_RECORDED = "NOT_RECORDED"
_NUMBER = re.compile(r"\d+")


class Sample(NamedTuple):
    """Memory and threads of the node, so many seconds after the soak and its process began."""

    at: float
    age: float
    life: int
    bytes: int
    threads: int


class Simulated(NamedTuple):
    """A simulation that a client was told of."""

    body: int
    restitution: float
    seed: int
    asked: int
    drops: int


@dataclass
class Tally:
    """Everything that was asked, told and injected.

    Attributes
    ----------
    seconds : dict
        Of the calls, by name.
    refusals : Counter
        By reason, without the values.
    messages : Counter
        Published, by kind.
    faults : Counter
    answers : set
        Results that clients were told, as `key_of` has them, but for those that said
        NOT_RECORDED.
    unrecorded : int
        How many of those there were.
    accepted : set of str
        Jobs.
    ends : dict of str to int
        How jobs ended.
    estimates, simulations
        What is to be compared with the library.
    samples : list of Sample
    cut : int
        Calls that were on their way when the node was killed or stopped.
    wrong : list of str
        Whatever must not be.
    """

    seconds: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    refusals: Counter[str] = field(default_factory=Counter)
    messages: Counter[str] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)
    diagnostics: Counter[str] = field(default_factory=Counter)
    answers: set[Any] = field(default_factory=set)
    unrecorded: int = 0
    accepted: set[str] = field(default_factory=set)
    ends: dict[str, int] = field(default_factory=dict)
    estimates: list[tuple[tuple[int, str, float], dict[int, float]]] = field(default_factory=list)
    simulations: dict[Simulated, dict[int, int]] = field(default_factory=dict)
    simulated: int = 0
    samples: list[Sample] = field(default_factory=list)
    cut: int = 0
    wrong: list[str] = field(default_factory=list)

    def refuse(self, message: str) -> None:
        """Count a refusal; it must be a reason in one line."""
        if not message.isprintable() or "internal failure" in message or not message:
            self.wrong.append(f"refused with {message!a}")
        reason = _NUMBER.sub("N", message.partition(", got ")[0].partition(" (")[0])
        self.refusals[reason.removeprefix("expected ")[:70]] += 1

    def told(self, statistics: Any) -> bool:
        """Note a result as acknowledged, unless it says that it is not on record."""
        if any(warning.startswith(NOT_RECORDED) for warning in statistics.warnings):
            self.unrecorded += 1
            return False
        self.answers.add(key_of(statistics))
        return True


def key_of(statistics: Any) -> tuple[Any, ...]:
    """What a result is known by: its place among the others, and what it says."""
    stamp = statistics.header.stamp
    return (statistics.part_id, statistics.part_digest, statistics.method, statistics.revision,
            stamp.sec, stamp.nanosec, statistics.job_id, statistics.drops, statistics.seed,
            tuple((pose.index, pose.count, repr(pose.probability)) for pose in statistics.poses))
