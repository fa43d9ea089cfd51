# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""`compile`: the machine code of all kernels, once for a user or an installation."""

import argparse
import time

from ...base import caches, errors
from .terminal import arguments, running


def register(commands: arguments.Commands) -> None:
    """Add the command."""
    command = commands.add_parser(
        "compile",
        help="compile all kernels, once for this user or for all",
        description="Compile all kernels, on all cores, and keep their machine code in "
        "`ros_pose_stats/` below `$NUMBA_CACHE_DIR`, else `$XDG_CACHE_HOME`, else "
        "`~/.cache`. Without it, the first command that needs one compiles all. "
        "`make setup` does it, too. Machine code is used only where it is yours or "
        "root's, and nobody else can write there or in a folder on the way.",
        examples=("ros_pose_stats compile", "sudo ros_pose_stats compile --system"),
        run=run,
    )
    command.add_argument(
        "--system",
        action="store_true",
        help="keep it beside the installation, for all users of it, as in an image "
        "that is built as root or on a system that can only be read",
    )


def run(options: argparse.Namespace) -> int:
    """Compile the missing kernels and print where all of them are."""
    from ...core.kernels import compilation, machine_code

    kernels = compilation.all_kernels()
    if options.system:
        keep_for_all()
    begin = time.monotonic()
    if running.compile_missing():
        print(f"compiled in {time.monotonic() - begin:.0f} s")
    stores = {kernel.store() for kernel in kernels}
    if None in stores:
        raise errors.RequestError(
            "a folder that machine code can be kept in",
            machine_code.complaint_about_caches() or "one that is full",
            "name one that you alone can write to: NUMBA_CACHE_DIR=FOLDER",
        )
    if options.system:
        caches.open_to_all(machine_code.INSTALLED)
    print(f"all {len(kernels)} kernels are in {' and '.join(map(str, stores))}")
    return 0


def keep_for_all() -> None:
    """Keep machine code beside the installation from here on."""
    from ...core.kernels import machine_code

    try:
        machine_code.choose_shared_store()
    except OSError as error:
        raise errors.RequestError(
            "an installation in folders that its owner alone can write to",
            f"{error.filename} ({errors.reason(error)})",
            "run this as the owner, after `chmod go-w` of that folder",
        ) from error
