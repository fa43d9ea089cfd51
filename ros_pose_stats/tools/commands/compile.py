"""`compile`: the machine code of all kernels, once for a user."""

import argparse
import time

from .terminal import arguments, running


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    commands.add_parser(
        "compile",
        help="compile all kernels, once for this user",
        description="Compile all kernels, on all cores, and keep their machine code in "
        "`ros_pose_stats/` below `$NUMBA_CACHE_DIR`, else `$XDG_CACHE_HOME`, else "
        "`~/.cache`. Without it, the first command that needs one compiles all. "
        "`make setup` does it, too.",
        examples=("ros_pose_stats compile",),
        run=run,
    )


def run(options: argparse.Namespace) -> int:
    """Compile the missing kernels and print where all of them are."""
    from ...core.kernels import compilation, machine_code

    kernels = compilation.all_kernels()
    begin = time.monotonic()
    if running.compile_missing():
        print(f"compiled in {time.monotonic() - begin:.0f} s")
    folder = machine_code.cache_directory()
    unstored = [kernel for kernel in kernels if not kernel.is_stored()]
    if unstored:
        raise OSError(f"{len(unstored)} kernels into {folder}")
    print(f"all {len(kernels)} kernels are in {folder}")
    return 0
