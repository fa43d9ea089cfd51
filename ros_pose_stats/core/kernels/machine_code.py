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

"""The machine code of kernels: how it is made, and where it is kept.

numba compiles for the very processor it runs on, and optimises and emits every helper
by itself and again within each of its callers. Here the code is made for a named
baseline of processors, so that it is the same on all machines that have it, and a
helper is made ready to be linked and nothing more, which halves the time to compile.

numba's own cache goes by the path and time stamp of the file that defines a function,
and does not notice an edit in a helper or a constant imported from elsewhere. Here it
is one file a kernel, in a folder whose name is a digest of every source that a kernel
can depend on and of the compiler, and below it of the baseline: any checkout or
installation of the same sources finds it. It is looked for in the user's cache, and
beside the installation, where `compile --system` keeps it for all users.

numba has no public way to either. Each of its private members that is used says what it
is for.
"""

import errno
import hashlib
import os
import pickle
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import Any

if "numba" not in sys.modules:
    # Intel's library of vector functions would round sums of sines its own way where
    # installed.
    os.environ["NUMBA_DISABLE_INTEL_SVML"] = "1"

import llvmlite
import llvmlite.binding as llvm
import numba
from numba.core.runtime import rtsys

from ...base import caches
from ...base.errors import reason

core: Any = numba.core
config: Any = core.config  # its names are made at import and unknown to type checkers

NAME = caches.NAME

INSTALLED = Path(__file__).resolve().parents[2] / "__compiled__"
"""A cache beside the installation, as `__pycache__` is for modules."""

ENVIRONMENT = "_ZN08NumbaEnv"
"""What the name of a function's environment begins with."""

V3 = ("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave")
"""What x86-64-v3 adds to x86-64, in the names of LLVM."""


def baseline() -> str:
    """LLVM's name of the processors compiled for; `$NUMBA_CPU_NAME` wins."""
    if config.CPU_NAME:
        return str(config.CPU_NAME)
    return _baseline_of_this_machine()


@lru_cache(maxsize=1)
def _baseline_of_this_machine() -> str:
    if not llvm.get_process_triple().startswith("x86_64"):
        return "generic"
    features = llvm.get_host_cpu_features()  # takes milliseconds
    return "x86-64-v3" if all(features.get(name) for name in V3) else "x86-64"


class KernelLibrary(core.codegen.JITCodeLibrary):
    """Code of a function and all that it calls, optimised once it is to run.

    `_final_module` is that code, and `_ensure_finalized` and `_get_module_for_linking`
    close it.
    """

    _emitted = False

    def _optimize_functions(self, ll_module: Any) -> None:
        """Nothing before it is to run; LLVM must know the layout of data, though."""
        ll_module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        """Nothing before it is to run."""

    def _finalize_final_module(self) -> None:
        """Emit what is from the disk; close all else (`_finalized`), to be linked."""
        if self._object_caching_enabled and self._compiled_object is not None:
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
        """Machine code and its names; LLVM's form would be five times as large."""
        self._ensure_finalized()
        return (
            self.name,
            "object",
            (self._get_compiled_object(), _names_of(self._final_module)),
        )


def _names_of(module: Any) -> bytes:
    """A module with the names by which a kernel is called, and nothing behind them."""
    functions = [
        function.name
        for function in module.functions
        if not function.is_declaration and function.linkage == llvm.Linkage.external
    ]
    environments = {ENVIRONMENT + name.removeprefix("_ZN") for name in functions}
    text = [f'define void @"{name}"() {{ ret void }}' for name in functions]
    text += [
        f'@"{variable.name}" = global i8 0'
        for variable in module.global_variables
        if variable.name in environments
    ]
    return bytes(llvm.parse_assembly("\n".join(text)).as_bitcode())


def _defines(module: Any, name: str) -> bool:
    try:
        return not module.get_function(name).is_declaration
    except NameError:
        return False


class KernelCodegen(core.codegen.JITCPUCodegen):
    """Compiles for the baseline."""

    _library_class = KernelLibrary  # what it makes for each function

    def _get_host_cpu_name(self) -> str:
        """The processor that LLVM is asked to compile for."""
        return baseline()

    def _get_host_cpu_features(self) -> str:
        """What it has beyond those that its name stands for."""
        return str(config.CPU_FEATURES or "")

    def set_env(self, env_name: str, env: Any) -> None:
        """Hand a function its environment; a helper, which is not emitted, has none.

        `_engine` knows what has been emitted.
        """
        if self._engine.is_symbol_defined(env_name):
            super().set_env(env_name, env)


class KernelContext(core.cpu.CPUContext):
    """Lowers kernels."""

    def init(self) -> None:
        """Make what generates the code, numba's `_internal_codegen`."""
        super().init()
        self._internal_codegen = KernelCodegen("ros_pose_stats.core.kernels")


class KernelTarget(core.registry.CPUTarget):
    """The kernels' own target beside numba's `cpu`, which other users keep as it is."""

    @cached_property
    def target_context(self) -> KernelContext:
        """What lowers kernels, one for all threads."""
        return KernelContext(self.typing_context, NAME)


class KernelDispatcher(core.dispatcher.Dispatcher):
    """A function compiled for that target."""

    targetdescr = KernelTarget(NAME)

    def compile(self, sig: Any) -> Any:
        """Compile for a signature, or load what has been compiled for it."""
        with core.target_extension.target_override(NAME):
            return super().compile(sig)


class Kernels(core.target_extension.CPU):
    """Mark of that target."""


def _compile_overload(function: Any = None, **options: Any) -> Any:
    """Compile a function of numba's own, such as `np.zeros`, that a kernel calls."""
    if function is None:
        return partial(_compile_overload, **options)
    return KernelDispatcher(
        function,
        targetoptions={
            "nopython": True,
            "boundscheck": None,
            "no_cfunc_wrapper": True,
            **options,
        },
    )


core.target_extension.target_registry[NAME] = Kernels
core.target_extension.dispatcher_registry[Kernels] = KernelDispatcher
core.target_extension.jit_registry[Kernels] = _compile_overload


def source_digest() -> str:
    """Digest of the sources that the compiled code depends on, and of the compiler."""
    package = Path(__file__).resolve().parent
    versions = (numba.__version__, llvmlite.__version__, sys.implementation.cache_tag)
    digest = hashlib.sha256(repr(versions).encode())
    for source in sorted([*package.rglob("*.py"), package.parent / "tolerances.py"]):
        digest.update(source.name.encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def target() -> str:
    """Name of the folder of what is compiled for processors like this one."""
    return f"{baseline()}{'-svml' if config.USING_SVML else ''}"


@lru_cache(maxsize=1)
def _own_store() -> tuple[Path | None, str]:
    """The user's folder of machine code; where there is none, why."""
    complaints = []
    for cache in caches.cache_folders():
        directory = cache / source_digest()
        try:
            caches.make_folder(directory)
            caches.refuse_untrusted(directory)
        except OSError as error:
            complaints.append(f"{error.filename} ({reason(error)})")
            continue
        # A store that root has filled for all is as good as one's own.
        is_filled = any((directory / target()).glob("*.code"))
        if is_filled or os.access(directory, os.W_OK):
            return directory, ""
        complaints.append(f"{directory} (cannot be written)")
    return None, ", ".join(complaints) or "no folder is named for a cache"


def cache_directory() -> Path | None:
    """Directory of the user's machine code, by digest; None where there is none.

    Below `$NUMBA_CACHE_DIR`, else `$XDG_CACHE_HOME`, else `~/.cache`.
    """
    return _own_store()[0]


def complaint_about_caches() -> str:
    """Why machine code cannot be kept for this user; empty where it can be."""
    return _own_store()[1]


def shared_store() -> Path:
    """Directory of machine code for all users of this installation."""
    return INSTALLED / NAME / source_digest()


def choose_shared_store() -> Path:
    """Keep machine code for all users, here and in processes started; OSError."""
    store = shared_store()
    caches.make_folder(store)
    caches.refuse_untrusted(store)
    if not os.access(store, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(store))
    os.environ["NUMBA_CACHE_DIR"] = str(INSTALLED)
    _own_store.cache_clear()
    stores.cache_clear()
    return store


@lru_cache(maxsize=1)
def stores() -> tuple[Path, ...]:
    """Where machine code is looked for; what others could have written is left out."""
    own_store = cache_directory()
    shared = shared_store()
    with suppress(OSError):
        caches.refuse_untrusted(shared)
        return (shared,) if own_store in (None, shared) else (own_store, shared)
    return () if own_store is None else (own_store,)


class KernelFile:
    """The file of one kernel, behind the interface of numba's caches.

    `_reduce` takes a compiled kernel apart into what can be pickled, and `_rebuild`
    puts it together again. `fill_store` is called once, where code is missing for the
    first time; it may make all that is.
    """

    cache_path = None
    fill_store: Callable[[], object] | None = None

    def __init__(self, name: str) -> None:
        self._name = name

    def _copies(self) -> Iterator[tuple[Path, tuple[Any, ...]]]:
        """Stores that have it, each with the compiled kernel in pieces."""
        for store in stores():
            try:
                content = caches.read_sealed(store, f"{target()}/{self._name}.code")
                yield store, pickle.loads(content)
            except FileNotFoundError:
                continue
            except Exception as error:
                self._warn(f"in {store} cannot be read", error)

    def read(self) -> tuple[Any, ...] | None:
        """A compiled kernel in pieces; None where there is none or a damaged one."""
        return next((pieces for _, pieces in self._copies()), None)

    def store(self) -> Path | None:
        """Where it is sound, the first of such stores."""
        return next((store for store, _ in self._copies()), None)

    def load_overload(self, _: Any, context: Any) -> Any:
        """The compiled kernel, None where it is still to be compiled."""
        rtsys.initialize(context)
        stored = self.read()
        if stored is None and KernelFile.fill_store is not None:
            fill = KernelFile.fill_store
            KernelFile.fill_store = None
            fill()
            stored = self.read()
        if stored is None:
            return None
        return core.compiler.CompileResult._rebuild(context, *stored)

    def save_overload(self, _: Any, compiled: Any) -> None:
        """Keep a compiled kernel."""
        if compiled.library.has_dynamic_globals:
            raise ValueError(f"{self._name} holds addresses of this process")
        # The last are environments of helpers, which hold nothing; to load them means
        # to import the modules that they are from, half of numba and scipy.
        *pieces, _ = compiled._reduce()
        store = cache_directory()
        if store is None:
            return
        try:
            content = core.serialize.dumps((*pieces, ()))
            caches.write_sealed(store / target() / f"{self._name}.code", content)
        except OSError as error:
            self._warn(f"in {store} cannot be written", error)

    def _warn(self, failure: str, error: Exception) -> None:
        warnings.warn(
            f"machine code of {self._name} {failure} ({type(error).__name__}: {error})",
            RuntimeWarning,
            stacklevel=2,
        )
