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

"""How this machine plays older ones: environments in which libraries use what those
have.

OpenBLAS, as numpy and scipy bring it, has three sets of kernels for x86-64. The one of
this processor is used in all other tests.
"""

import os

from numpy._core._multiarray_umath import (
    __cpu_dispatch__ as dispatched,
    __cpu_features__ as features,
)

C_LIBRARY_WITHOUT_FMA = {
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-AVX2,-FMA,-FMA4"
}
COMPILED_OTHERWISE = {
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_OPT": "1",
    "NUMBA_LOOP_VECTORIZE": "0",
}
"""Kernels for any processor, and hardly optimised: as far from the usual ones as can
be.
"""


def played(kernels, newer):
    """Environment with kernels of OpenBLAS, and without newer features in numpy.

    Where the environment already chooses the kernels of OpenBLAS, they are left alone.
    """
    return {
        "OPENBLAS_CORETYPE": os.environ.get("OPENBLAS_CORETYPE", kernels),
        "NPY_DISABLE_CPU_FEATURES": " ".join(newer),
    }


def older_machines():
    """Environments of older processors, by what those have at most."""
    present = [name for name in dispatched if features[name]]
    machines = {}
    if features.get("AVX512_SKX"):
        newer = [name for name in present if name.startswith("AVX512")]
        machines["AVX2"] = played("Haswell", newer)
    if features.get("AVX2"):
        machines["SSE3"] = played("Prescott", present) | C_LIBRARY_WITHOUT_FMA
    return machines


MACHINES = older_machines()
OLDEST = list(MACHINES)[-1:]
