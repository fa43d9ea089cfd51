"""`compile` and `shapes DIR`: machine code of every kernel, and the demo parts."""

import argparse
import time

from . import arguments as given, running


def register(commands: given.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "compile", help="compile all kernels, once for this user",
        description="Compile all kernels, on all cores, and keep their machine code in "
        "`ros_pose_stats/` below `$NUMBA_CACHE_DIR`, else `$XDG_CACHE_HOME`, else `~/.cache`. "
        "Without it, the first command that needs one compiles all. "
        "`make setup` does it, too.",
        examples=("ros_pose_stats compile",))
    command.set_defaults(run=run)


def run(_: argparse.Namespace) -> int:
    """Compile the missing kernels and print where all of them are."""
    from ..kernels import compilation, machine_code

    kernels = compilation.all_kernels()
    begin = time.monotonic()
    if running.compile_missing():
        print(f"compiled in {time.monotonic() - begin:.0f} s")
    lost = [one for one in kernels if not one.is_stored()]
    if lost:
        raise OSError(f"{len(lost)} kernels into {machine_code.cache_directory()}")
    print(f"all {len(kernels)} kernels are in {machine_code.cache_directory()}")
    return 0


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
