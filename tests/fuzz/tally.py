"""What became of all inputs, as a table."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field

from .trial import Outcome


@dataclass
class Row:
    """What became of the inputs of one kind.

    Attributes
    ----------
    tried, taken : int
    refused, compared : Counter
        By reason.
    slowest : Outcome or None
    failed : list of Outcome
    """

    tried: int = 0
    taken: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    compared: Counter[str] = field(default_factory=Counter)
    slowest: Outcome | None = None
    failed: list[Outcome] = field(default_factory=list)

    def add(self, outcome: Outcome) -> None:
        """Count one input in."""
        self.tried += 1
        if outcome.refusal:
            self.refused[reason(outcome.refusal)] += 1
        else:
            self.taken += 1
        if outcome.compared:
            self.compared[outcome.compared] += 1
        if self.slowest is None or outcome.seconds > self.slowest.seconds:
            self.slowest = outcome
        if outcome.faults:
            self.failed.append(outcome)


class Tally(dict[str, Row]):
    """Rows by kind, in the order in which the kinds came."""

    def add(self, outcome: Outcome) -> None:
        """Count one input in."""
        self.setdefault(outcome.kind, Row()).add(outcome)

    @property
    def tried(self) -> int:
        """All inputs."""
        return sum(row.tried for row in self.values())

    @property
    def failed(self) -> list[Outcome]:
        """All inputs with a fault."""
        return [outcome for row in self.values() for outcome in row.failed]


def reason(refusal: str) -> str:
    """A refusal without the numbers of the case."""
    return re.sub(r"from 0 to \d+", "in range", refusal)


def table(tally: Tally) -> str:
    """A line a kind, then the reasons of refusals, then every failure with its seed."""
    lines = [f"{'kind':24} {'tried':>7} {'taken':>7} {'refused':>7} {'failed':>6} "
             f"{'slowest':>8} {'its seed':>9}  given in other ways"]
    for kind, row in tally.items():
        slowest = row.slowest
        ways = ", ".join(f"{name} {count}" for name, count in row.compared.most_common())
        lines.append(f"{kind:24} {row.tried:7} {row.taken:7} {row.refused.total():7} "
                     f"{len(row.failed):6} {slowest.seconds if slowest else 0.0:6.3f} s "
                     f"{slowest.seed if slowest else 0:9}  {ways}")
    taken = sum(row.taken for row in tally.values())
    lines += ["", f"{tally.tried} inputs, {taken} taken, {tally.tried - taken} refused, "
              f"{len(tally.failed)} failed", "", "refused"]
    reasons = sum((row.refused for row in tally.values()), Counter[str]())
    lines += [f"{count:7}  {text}" for text, count in reasons.most_common()]
    lines += ["", "failures"] * bool(tally.failed)
    lines += [failure(outcome) for outcome in tally.failed]
    return "\n".join(lines)


def failure(outcome: Outcome) -> str:
    """One failure, and how to see it again."""
    what = "; ".join(dict.fromkeys(outcome.faults))
    return (f"{outcome.kind}, seed {outcome.seed}: {what[:300]}\n    python -m tests.fuzz "
            f"--kind '{outcome.kind}' --seed {outcome.seed} --meshes 1")
