"""What the rows of a catalogue come to: how many parts feed well, are in doubt, were refused."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from ..text import code_of, is_serious
from .rows import Row

ONE_WAY = 0.9
"""Share of the best pose from which on a part is said to lie one way."""


@dataclass
class Tally:
    """Counts over rows."""

    # parts that were not refused, and those of them whose best pose has at least `ONE_WAY`
    answered: int = 0
    one_way: int = 0
    doubted: int = 0  # parts with serious warnings
    # parts by the code of a serious warning, the most frequent first when listed
    serious: Counter[str] = field(default_factory=Counter)
    refused: dict[str, str] = field(default_factory=dict)  # reasons by the names of the files

    @property
    def codes(self) -> str:
        """The codes of serious warnings with their numbers, in words."""
        return ", ".join(f"{code} {count}" for code, count in self.serious.most_common())


def tally(rows: Iterable[Row]) -> Tally:
    """Count what rows say."""
    found = Tally()
    for row in rows:
        if row["refusal"]:
            found.refused[row["file"]] = row["refusal"]
            continue
        found.answered += 1
        share = row["best_share"]
        found.one_way += share is not None and share >= ONE_WAY
        codes = {code_of(one) for one in row["warnings"] if is_serious(one)}
        found.doubted += bool(codes)
        found.serious.update(sorted(codes))
    return found
