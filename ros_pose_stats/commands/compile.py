"""`compile` and `shapes DIR`: machine code of every kernel, and the demo parts."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import time
from typing import TYPE_CHECKING

from . import arguments as given, running

if TYPE_CHECKING:
    from ..kernels.compilation import EntryKernel


TOGETHER = (
    ("drops.drop", "drops.evolve"),
    ("levels.splits", "features.split_features", "features.corner_crowding"),
    ("body.convex_body", "body.coplanar", "features.surface_features"),
)
"""Modules whose kernels share helpers, which are compiled once a process; longest first."""

GLANCE = 0.1
"""Seconds between checks of the kernels stored so far."""


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "compile", help="compile all kernels, once for this user",
        description="Compile all kernels, on all cores, and keep their machine code in "
        "`ros_pose_stats/` below `$NUMBA_CACHE_DIR`, else `$XDG_CACHE_HOME`, else `~/.cache`. "
        "Without it, every command compiles the kernels that it is the first to need. "
        "`make setup` does it, too.",
        examples=("ros_pose_stats compile",))
    command.set_defaults(run=run)


def run(_: argparse.Namespace) -> int:
    """Compile the missing kernels, naming each, and print where all of them are."""
    from ..kernels import compilation, machine_code

    kernels = compilation.all_kernels()
    missing = [one for one in kernels if not one.is_stored()]
    if missing:
        begin = time.monotonic()
        _compile_all(missing)
        print(f"compiled in {time.monotonic() - begin:.0f} s")
    lost = [one for one in missing if not one.is_stored()]
    if lost:
        raise OSError(f"{len(lost)} kernels into {machine_code.cache_directory()}")
    print(f"all {len(kernels)} kernels are in {machine_code.cache_directory()}")
    return 0


def _compile_all(missing: list[EntryKernel]) -> None:
    import multiprocessing  # which no other command wants
    from concurrent.futures import ProcessPoolExecutor, wait

    families = _families(missing)
    workers = min(len(families), os.cpu_count() or 1)
    left, done = list(missing), 0
    with (ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _end_quietly) as pool,
          running.ProgressBar(sys.stderr) as bar):
        pending = {pool.submit(compile_family, family) for family in families}
        while pending:
            finished, pending = wait(pending, GLANCE)
            for future in finished:
                future.result()
            for one in [one for one in left if one.is_stored()]:
                left.remove(one)
                done += 1
                if not sys.stderr.isatty():
                    print(f"{one.name} ({done} of {len(missing)})", flush=True)
            bar.draw(done / len(missing), f"{done} of {len(missing)} kernels")


def _families(kernels: list[EntryKernel]) -> list[list[str]]:
    """Names of the kernels that one process is to compile, those that take longest first."""
    families: list[list[str]] = [[] for _ in (*TOGETHER, "all others")]
    for one in kernels:
        module = one.py_func.__module__.partition(".kernels.")[2]
        place = next((k for k, modules in enumerate(TOGETHER) if module in modules), -1)
        families[place].append(one.name)
    return [family for family in families if family]


def compile_family(names: list[str]) -> None:
    """Compile kernels in this process."""
    from ..kernels.compilation import all_kernels

    for one in all_kernels():
        if one.name in names:
            one.prepare()


def _end_quietly() -> None:
    """Let a worker end silently on Ctrl-C, since the command itself prints a line."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def register_shapes(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser("shapes", help="write the demo parts as STL files",
                                  description="Write the demo parts (clamp, bracket, hex bolt, "
                                  "gear, prism, cylinder) as STL files in millimetres.",
                                  examples=("ros_pose_stats shapes demo",))
    command.add_argument("directory", metavar="DIR",
                         help="directory for the files; created if it is missing")
    command.set_defaults(run=run_shapes)


def run_shapes(options: argparse.Namespace) -> int:
    """Write the files and name them."""
    from ..shapes.demo_parts import write_demo_parts

    for path in write_demo_parts(options.directory):
        print(path)
    return 0
