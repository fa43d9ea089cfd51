"""The page of reliability, from what the attacks gave."""

from __future__ import annotations

from collections.abc import Mapping

from .attacks import ATTACKS, Outcome

INTRODUCTION = """# Reliability

*This page is written by `python -m tests.soak.attacks --write`.*

What careless and hostile neighbours do to the node, in miniature: each attack meets a node of its
own, in a process of its own, with meshes of 2 MB where nothing else is said. Broken is how many of
the attack's promises were not kept. The machine was shared, so times give an idea only. Longer
runs: `tests.soak.node` (calls, faults, memory), `tests.fuzz` (meshes and messages), and the long
tests of `tests/ros/restart` (kills at any moment).

| attack | what is done | trials | broken | seen |
|---|---|---|---|---|
"""


def reliability_page(outcomes: Mapping[str, Outcome], machine: Mapping[str, str]) -> str:
    """Markdown, with the machine in its last line."""
    rows = [f"| {name} | {(ATTACKS[name].__doc__ or '').rstrip('.')} | {one.trials} | "
            f"{len(one.broken)} | {one.measured} |" for name, one in outcomes.items()]
    return INTRODUCTION + "\n".join(rows) + (
        f"\n\n{', '.join(f'{key} {value}' for key, value in machine.items())}.\n")
