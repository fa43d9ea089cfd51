"""Loads the kernels before the first client comes, and compiles those that are missing."""

from __future__ import annotations

import time
from collections.abc import Callable

from ..kernels.compilation import all_kernels, prepare_kernels, watch_compilations


def warm_up(say: Callable[[str], object]) -> None:
    """Have the machine code of every kernel at hand.

    Parameters
    ----------
    say : callable
        Told if kernels are compiled, which takes a minute or more.
    """
    begin = time.monotonic()
    compiled: list[str] = []

    def tell(kernel: str) -> None:
        if not compiled:
            say("compiling kernels, which takes a minute or more; `ros_pose_stats compile` does "
                "so once for all later starts")
        compiled.append(kernel)

    all_kernels()
    with watch_compilations(tell):
        prepare_kernels()
    if compiled:
        say(f"{len(compiled)} kernels compiled in {time.monotonic() - begin:.0f} s")
