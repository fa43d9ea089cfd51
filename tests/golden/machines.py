"""How this machine plays others: environments in which libraries use what other
processors have.

Where the environment already chooses the kernels of OpenBLAS, they are left alone.
"""

import os
from pathlib import Path

from numpy._core._multiarray_umath import __cpu_features__ as numpy_features


def processor_flags():
    """What the processor has, as Linux names it; elsewhere as numpy does."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return {name.lower() for name, present in numpy_features.items() if present}
    return set(next((line for line in lines if line.startswith("flags")), "").split())


KERNELS = {
    "Prescott": "pni",
    "Haswell": "avx2",
    "Zen": "avx2",
    "SkylakeX": "avx512vl",
    "Cooperlake": "avx512_bf16",
    "SapphireRapids": "avx512_bf16",
}
"""Kernels of OpenBLAS, and what a processor must have for them."""

LIBRARIES = {
    "C library without FMA": (
        "avx2",
        {
            "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-AVX2,-FMA,-FMA4"
        },
    ),
    "numpy without AVX512": (
        "avx512vl",
        {"NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX"},
    ),
    "numpy without AVX2": ("avx2", {"NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3"}),
}

COMPILED_OTHERWISE = {
    "generic code": {"NUMBA_CPU_NAME": "generic"},
    "code hardly optimised": {"NUMBA_OPT": "1", "NUMBA_LOOP_VECTORIZE": "0"},
}


def playable():
    """Environments by name that this processor can run."""
    flags = processor_flags()
    kernels = (
        {}
        if "OPENBLAS_CORETYPE" in os.environ
        else {
            f"BLAS for {name}": {"OPENBLAS_CORETYPE": name}
            for name, needed in KERNELS.items()
            if needed in flags
        }
    )
    return kernels | {
        name: environment
        for name, (needed, environment) in LIBRARIES.items()
        if needed in flags
    }


PLAYED = playable()

WITHOUT = {
    "SSE3": ("Prescott", "C library without FMA", "numpy without AVX2"),
    "AVX2": ("Haswell", "numpy without AVX512"),
    "AVX512": ("SkylakeX",),
}
"""What whole machines have at most, and the environments that make them so."""

MACHINES = {
    name: {
        key: value
        for word in made_by
        for played in (word, f"BLAS for {word}")
        for key, value in PLAYED.get(played, {}).items()
    }
    for name, made_by in WITHOUT.items()
}
"""Whole machines in place of one library each: a process for each generation of
processors.
"""
