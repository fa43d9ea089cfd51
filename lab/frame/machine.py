"""The machine that something is measured on."""

import os
import platform
from datetime import date
from importlib.metadata import version
from pathlib import Path

LIBRARIES = ("numpy", "scipy", "numba", "trimesh")


def describe_machine() -> dict[str, str]:
    """Processor, cores, versions, the date, and what may slow a run down.

    Idle threads of the linear algebra library spin for a while; on a busy machine they
    take time from the calling thread, so their number and the load belong to a result.
    """
    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "python": platform.python_version(),
        **{library: version(library) for library in LIBRARIES},
        "BLAS threads": os.environ.get("OPENBLAS_NUM_THREADS", "default"),
        "load at the start": f"{os.getloadavg()[0]:.1f}",
        "date": date.today().isoformat(),
    }


def _processor() -> str:
    """Model name of the processor, where the system has it."""
    description = Path("/proc/cpuinfo")
    if description.exists():
        for line in description.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
