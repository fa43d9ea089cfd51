"""System calls that fail when they are told to, and take effect half before."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterable
from contextlib import suppress

import pytest

CALLS = ("open", "pwritev", "write", "fsync", "fdatasync", "ftruncate", "mkdir", "rename",
         "replace", "unlink", "stat", "scandir")


class Faults:
    """Counts the calls and lets some fail.

    Parameters
    ----------
    patch : MonkeyPatch
        Puts the real calls back.
    fails : callable
        Whether the call with this number, from 0, fails.
    calls : iterable of str
        Names of functions of `os` that are counted.
    """

    def __init__(self, patch: pytest.MonkeyPatch, fails: Callable[[int], bool],
                 calls: Iterable[str] = CALLS) -> None:
        self.count = 0
        self.failed: list[str] = []
        self._fails = fails
        for name in calls:
            patch.setattr(os, name, self._wrapped(name, getattr(os, name)))

    def _wrapped(self, name: str, real: Callable) -> Callable:
        def call(*arguments, **named):
            number, self.count = self.count, self.count + 1
            if not self._fails(number):
                return real(*arguments, **named)
            self.failed.append(name)
            if name == "pwritev":
                self._write_half(real, *arguments)
            code = errno.EIO if "sync" in name else errno.ENOSPC
            raise OSError(code, os.strerror(code))
        return call

    @staticmethod
    def _write_half(real: Callable, number: int, buffers: list, offset: int) -> None:
        data = b"".join(buffers)
        with suppress(OSError):
            real(number, [data[:len(data) // 2]], offset)
