"""A program of its own: STEP on standard input, its tessellation as GLB on standard output.

On some damaged files OpenCASCADE ends the whole process, and it prints as it likes. Here that
harms nobody. `cascadio`'s own module, which loads all of trimesh, is left out: only its compiled
core is needed, and that takes a tenth of the time.
"""

import ctypes
import importlib.util
import os
import signal
import sys

ANGLE = 0.131
"""A little over 7.5 degrees, half of which an arc spans at most: 96 sides a turn, whatever the
radius, and whole sides in every arc of a multiple of 15 degrees, so that the halves and quarters
into which CAD systems divide a circle are regular. Half of the sides that round surfaces have in
drops."""

LINEAR = 1.5e-3
"""Largest distance from the true curve, as a fraction of each edge, so that a hole has as many
sides as a rim a thousand times its size, whatever the unit. On circles the angle decides; at 1e-3
this would divide some of them by 100."""


PR_SET_PDEATHSIG = 1
"""Of Linux's `prctl`."""


def main(folder: str, parent: int) -> None:
    """Convert, with cascadio's package in this folder, for a process that is the parent."""
    end_with(parent)
    answer = os.dup(1)
    os.dup2(2, 1)
    sys.path.insert(0, folder)
    found = importlib.util.find_spec("cascadio")
    assert found is not None
    sys.modules["cascadio"] = importlib.util.module_from_spec(found)
    from cascadio import _core

    # One thread, so that the order of the triangles is never a matter of chance.
    glb = _core.to_glb_bytes(sys.stdin.buffer.read(), _core.FileType.STEP, tol_linear=LINEAR,
                             tol_angular=ANGLE, tol_relative=True, use_parallel=False)
    with os.fdopen(answer, "wb") as output:
        output.write(glb)


def end_with(parent: int) -> None:
    """Have this process end when its parent does, even by `kill -9`; a file may take minutes."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it was quicker
        os._exit(1)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
