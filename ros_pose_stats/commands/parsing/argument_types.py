"""Numbers as people type them: 1e5 drops, poses 0,1 or 0 1."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from decimal import Decimal, InvalidOperation
from typing import Any

MOST_DIGITS = 30
"""Of a whole number; more than any seed has."""

SHOWN = 60
"""Signs of what came that a refusal repeats."""


def read_count(text: str) -> int:
    """A whole number, in digits or in scientific notation.

    Whether it is in range is for those to say who use it.

    Raises
    ------
    argparse.ArgumentTypeError
        If it is something else, with what was expected and what came.
    """
    try:
        number = Decimal(text)
    except InvalidOperation:
        raise _refusal("a whole number, for instance 100000 or 1e5", text) from None
    if not number.is_finite():
        raise _refusal("a whole number, for instance 100000 or 1e5", text)
    # Looked at before anything is computed: 1e999999999 as an integer fills the memory.
    if number.adjusted() >= MOST_DIGITS:
        raise _refusal(f"a whole number of at most {MOST_DIGITS} digits", text)
    if number != number.to_integral_value():
        raise _refusal("a whole number, for instance 100000 or 1e5", text)
    return int(number)


def read_indices(text: str) -> list[int]:
    """Indices of poses, separated by commas or spaces.

    Raises
    ------
    argparse.ArgumentTypeError
        If one of them is no whole number, or there is none.
    """
    pieces = [piece.split() for piece in text.strip().removesuffix(",").split(",")]
    words = [word for piece in pieces for word in piece]
    if not all(pieces) or not all(word.removeprefix("-").isdecimal() for word in words):
        raise _refusal("indices of poses, for instance 0,1 or 0 1", text)
    return [read_count(word) for word in words]


class JoinIndices(argparse.Action):
    """Makes one list of the lists that `read_indices` returned."""

    def __call__(self, parser: argparse.ArgumentParser, namespace: argparse.Namespace,
                 values: str | Sequence[Any] | None, option_string: str | None = None) -> None:
        """Store the list."""
        setattr(namespace, self.dest, [index for each in values or () for index in each])


def _refusal(expected: str, text: str) -> argparse.ArgumentTypeError:
    shown = text if len(text) <= SHOWN else f"{text[:SHOWN - 1]}…"
    return argparse.ArgumentTypeError(f"expected {expected}, got {shown!r}")
