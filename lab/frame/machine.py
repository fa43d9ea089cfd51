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
