"""Compiles or loads the kernels before the first client comes."""

from __future__ import annotations

import time
from collections.abc import Callable

from ..estimators import estimate
from ..geometry.parts import part_from_mesh
from ..geometry.shapes.closed_forms import cylinder
from ..planning import hybrid

LONG = 5.0


def warm_up(say: Callable[[str], object]) -> None:
    """Run everything once on a small part.

    Parameters
    ----------
    say : callable
        Told if it took long, which it does the first time on a machine.
    """
    begin = time.monotonic()
    say("loading kernels; the first time on a machine they are compiled, which takes "
        "a minute or more")
    part = part_from_mesh(*cylinder(32, 0.01, 0.03))
    estimate(part)
    hybrid(part, 16, seed=1, workers=1)
    took = time.monotonic() - begin
    if took > LONG:
        say(f"kernels compiled in {took:.0f} s")
