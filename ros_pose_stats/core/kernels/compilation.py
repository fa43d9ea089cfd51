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

"""How kernels are compiled: once, for the signature of their annotations."""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property, update_wrapper
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from threading import RLock, Thread
from typing import Any, TypeVar

from numba.core.compiler_lock import global_compiler_lock
from numba.extending import typeof_impl

from .array_types import signature_of
from .machine_code import (
    KernelDispatcher,
    KernelFile,
    cache_directory,
    complaint_about_caches,
    config,
)

Function = TypeVar("Function", bound=Callable[..., Any])

# No fastmath: "no event" is infinity, and it would be assumed away.
OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "nopython": True,
    "boundscheck": None,
    "no_cfunc_wrapper": True,  # none is called from C
}

# `_nrt`, an option that numba keeps to itself: without its run time a helper counts no
# references, and can make no arrays.
INLINED: dict[str, Any] = {"forceinline": True, "_nrt": False}


class Helper:
    """A function that becomes part of the kernels that call it.

    numba's dispatcher of it is made when a kernel is compiled: to make a hundred takes
    as long as loading the machine code.
    """

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self._options = {**OPTIONS, **options}

    @cached_property
    def merged(self) -> KernelDispatcher:
        """What numba is to take it for within a kernel."""
        options = {**self._options, "no_cpython_wrapper": True}
        return KernelDispatcher(self.py_func, targetoptions=options)

    @cached_property
    def _standalone(self) -> KernelDispatcher:
        return KernelDispatcher(self.py_func, targetoptions=self._options)

    def __call__(self, *arguments: Any) -> Any:
        """Compile and call it by itself, for whatever it is handed."""
        return self._standalone(*arguments)


typeof_impl.register(
    Helper, lambda helper, context: typeof_impl(helper.merged, context)
)


class EntryKernel(KernelDispatcher):
    """An outermost kernel: one signature, its machine code on disk.

    Arguments of other types are refused, for to compile anew takes as long as a
    thousand runs. Types are made with the kernel (`declared`): numba gives two numbers
    to a type that two threads make at once. `_cache` is where numba's dispatcher looks
    before it compiles, and keeps what it has compiled.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function, targetoptions=dict(OPTIONS))
        self._cache = KernelFile(f"{function.__module__}.{function.__qualname__}")
        self.declared = signature_of(function)
        self._first_call = RLock()
        self._has_run = False

    def __call__(self, *arguments: Any) -> Any:
        """Run it, alone the first time: in other threads numba might find no code."""
        if self._has_run:
            return super().__call__(*arguments)
        with self._first_call:
            self.prepare()
            answer = super().__call__(*arguments)
            self._has_run = True
            return answer

    @property
    def name(self) -> str:
        """Of the function."""
        return str(self.py_func.__name__)

    def store(self) -> Path | None:
        """The folder in which sound machine code lies; None where there is none."""
        return self._cache.store()

    def prepare(self) -> None:
        """Load the machine code, or compile it where there is none."""
        with global_compiler_lock:
            if not self.overloads:
                self.compile(self.declared)
                self.disable_compile()


_entry_kernels: list[EntryKernel] = []


def kernel(function: Function) -> Function:
    """Compile a helper into the kernels that call it."""
    if config.DISABLE_JIT:
        return function
    return Helper(function)  # type: ignore[return-value]


def inlined(function: Function) -> Function:
    """Compile a helper that is merged into its caller and borrows its arrays.

    Counting their references would cost more than its arithmetic. It cannot make arrays
    of its own.
    """
    if config.DISABLE_JIT:
        return function
    return Helper(function, **INLINED)  # type: ignore[return-value]


def entry_kernel(function: Function) -> Function:
    """Compile an outermost kernel and keep its machine code on disk."""
    if config.DISABLE_JIT:
        return function
    outermost_kernel = EntryKernel(function)
    _entry_kernels.append(outermost_kernel)
    return outermost_kernel


def all_kernels() -> list[EntryKernel]:
    """Every outermost kernel of the package; none where numba does not compile."""
    package = import_module(__package__)
    for module in walk_packages(package.__path__, f"{__package__}."):
        import_module(module.name)
    return [
        kernel
        for kernel in _entry_kernels
        if kernel.py_func.__module__.startswith(__package__)
    ]


def prepare_kernels() -> None:
    """Load or compile the machine code of all kernels imported so far."""
    for kernel in _entry_kernels:
        kernel.prepare()


@contextmanager
def filling_store(fill: Callable[[], object]) -> Iterator[None]:
    """Call `fill` before the first kernel is compiled in the context."""
    KernelFile.fill_store = fill
    try:
        yield
    finally:
        KernelFile.fill_store = None


def announcement() -> str:
    """What to say before kernels are compiled: how long it takes, and how often."""
    complaint = complaint_about_caches()
    if complaint:
        return (
            "compiling kernels, at every start for a minute, since they can be kept "
            f"nowhere: {complaint}"
        )
    return "compiling kernels for this machine, once; it takes a minute or two"


FAMILIES = (
    ("drops.drop", "drops.evolve"),
    ("levels.splits", "features.split_features", "features.corner_crowding"),
    ("body.convex_body", "body.coplanar", "features.surface_features"),
)
"""Modules whose kernels share helpers, compiled once a process; longest first."""

GLANCE = 0.1  # seconds between looks at what has been stored


def compile_missing(on_progress: Callable[[int, int], object]) -> int:
    """Compile all kernels that are not stored, on all cores; return their number.

    Nothing is done where the code cannot be kept: each process makes its own.
    """
    import multiprocessing  # which nothing else wants
    from concurrent.futures import ProcessPoolExecutor, wait

    missing = [kernel for kernel in all_kernels() if kernel.store() is None]
    total = len(missing)
    if not missing or cache_directory() is None:
        return 0
    families: list[list[str]] = [[] for _ in (*FAMILIES, "all others")]
    for kernel in missing:
        module = kernel.py_func.__module__.partition(".kernels.")[2]
        family = next(
            (k for k, modules in enumerate(FAMILIES) if module in modules), -1
        )
        families[family].append(kernel.name)
    with ProcessPoolExecutor(
        min(len(families), os.cpu_count() or 1),
        multiprocessing.get_context("spawn"),
        _end_with_the_command,
    ) as pool:
        pending = {pool.submit(_compile_family, names) for names in families if names}
        while pending:
            finished, pending = wait(pending, GLANCE)
            for future in finished:
                future.result()
            missing = [kernel for kernel in missing if kernel.store() is None]
            on_progress(total - len(missing), total)
    return total


def _compile_family(names: list[str]) -> None:
    for kernel in all_kernels():
        if kernel.name in names:
            kernel.prepare()


def _end_with_the_command() -> None:
    """Let a worker end where the command is killed, and silently on Ctrl-C.

    The pool's workers would wait for each other for ever. On Ctrl-C the command itself
    prints a line.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    Thread(target=_await_the_end, daemon=True).start()


def _await_the_end() -> None:
    from multiprocessing import parent_process

    if command := parent_process():
        command.join()
        os._exit(1)
