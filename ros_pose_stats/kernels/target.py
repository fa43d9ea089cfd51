"""The machine code that kernels become: for a baseline of processors, each kernel in one piece.

numba compiles for the very processor it runs on, and optimises and emits every helper by
itself and again within each of its callers. Here the code is made for a named baseline, so
that it is the same on all machines that have it, and a helper is made ready to be linked and
nothing more.
"""

from __future__ import annotations

import os
import sys
from functools import cached_property, lru_cache
from typing import Any

if "numba" not in sys.modules:
    # Intel's library of vector functions would round sums of sines its own way where installed.
    os.environ["NUMBA_DISABLE_INTEL_SVML"] = "1"

import llvmlite.binding as llvm
import numba
from numba.core import config as _config
from numba.core import typing
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.cpu import CPUContext
from numba.core.dispatcher import Dispatcher
from numba.core.registry import CPUTarget
from numba.core.target_extension import (
    CPU,
    dispatcher_registry,
    jit_registry,
    target_override,
    target_registry,
)

# Names that are made at import, or that type checkers are told too little of.
config: Any = _config
jit: Any = numba.jit

NAME = "ros_pose_stats"

ENVIRONMENT = "_ZN08NumbaEnv"
"""What the name of a function's environment begins with."""

V3 = ("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave")
"""What x86-64-v3 adds to x86-64, in the names of LLVM."""


def baseline() -> str:
    """LLVM's name of the processors that kernels are compiled for.

    `$NUMBA_CPU_NAME` wins; an x86-64 of 2015 or later is taken as x86-64-v3.
    """
    if config.CPU_NAME:
        return str(config.CPU_NAME)
    return _baseline_of_this_machine()


@lru_cache(maxsize=1)
def _baseline_of_this_machine() -> str:
    if not llvm.get_process_triple().startswith("x86_64"):
        return "generic"
    has = llvm.get_host_cpu_features()  # takes milliseconds
    return "x86-64-v3" if all(has.get(name) for name in V3) else "x86-64"


class KernelLibrary(JITCodeLibrary):
    """Code of one function and all that it calls, optimised and emitted once it is to run."""

    _emitted = False

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout  # and no more before it is to run

    def _optimize_final_module(self) -> None:
        """Nothing before it is to run."""

    def _finalize_final_module(self) -> None:
        if self._object_caching_enabled and self._compiled_object is not None:  # from the disk
            self._emitted = True
            super()._finalize_final_module()
        else:
            self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Address of one of its functions, which is emitted by then; 0 for another."""
        self._ensure_finalized()
        if not self._emitted and _defines(self._final_module, name):
            self._emitted = True
            self._get_module_for_linking()  # as it is now
            super()._optimize_final_module()
            self._final_module.verify()
            super()._finalize_final_module()
        return int(super().get_pointer_to_function(name))

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """Machine code and the names in it; nothing is linked to a kernel from the disk."""
        self._ensure_finalized()
        return self.name, "object", (self._get_compiled_object(), _names_of(self._final_module))


def _names_of(module: Any) -> bytes:
    """A module with the names by which a kernel is called, and nothing behind them."""
    functions = [one.name for one in module.functions
                 if not one.is_declaration and one.linkage == llvm.Linkage.external]
    environments = {ENVIRONMENT + name.removeprefix("_ZN") for name in functions}
    text = [f'define void @"{name}"() {{ ret void }}' for name in functions]
    text += [f'@"{one.name}" = global i8 0' for one in module.global_variables
             if one.name in environments]
    return bytes(llvm.parse_assembly("\n".join(text)).as_bitcode())


def _defines(module: Any, name: str) -> bool:
    try:
        return not module.get_function(name).is_declaration
    except NameError:
        return False


class KernelCodegen(JITCPUCodegen):
    """Compiles for the baseline."""

    _library_class = KernelLibrary

    def _get_host_cpu_name(self) -> str:
        return baseline()

    def _get_host_cpu_features(self) -> str:
        return str(config.CPU_FEATURES or "")  # those that the name stands for

    def set_env(self, env_name: str, env: Any) -> None:
        """Tell a function its environment; a helper, which is not emitted, has none."""
        if self._engine.is_symbol_defined(env_name):
            super().set_env(env_name, env)


class KernelContext(CPUContext):
    """Lowers kernels."""

    def init(self) -> None:
        """Make what generates the code."""
        super().init()
        self._internal_codegen = KernelCodegen("ros_pose_stats.kernels")

    def create_cfunc_wrapper(self, *_: Any, **__: Any) -> None:
        """None: no kernel is called from C."""


class KernelTarget(CPUTarget):
    """The kernels' own target beside numba's `cpu`, which other users keep as it is."""

    @cached_property
    def _toplevel_target_context(self) -> KernelContext:
        return KernelContext(self.typing_context, self._target_name)

    @cached_property
    def _toplevel_typing_context(self) -> typing.Context:
        return typing.Context()


class Kernels(CPU):
    """Mark of that target."""


target_registry[NAME] = Kernels


class KernelDispatcher(Dispatcher):
    """A function compiled for that target."""

    targetdescr = KernelTarget(NAME)

    def compile(self, sig: Any) -> Any:
        """Compile for a signature, or load what has been compiled for it."""
        with target_override(NAME):
            return super().compile(sig)


def compile_kernel(*arguments: Any, **options: Any) -> Any:
    """`numba.njit` for kernels."""
    return jit(*arguments, _target=NAME, **options)


dispatcher_registry[Kernels] = KernelDispatcher
jit_registry[Kernels] = compile_kernel
