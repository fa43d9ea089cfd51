"""The parser of every command: refusals in one line, and an example at the end of its help."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import Any, NoReturn

REFUSED = 2


class CommandParser(argparse.ArgumentParser):
    """A parser whose refusals are one line, and for whom -1e-3 is a number, not an option.

    Parameters
    ----------
    examples : sequence of str
        Whole lines as they are typed, shown at the end of the help.
    **options
        As for argparse.
    """

    def __init__(self, *, examples: Sequence[str] = (), **options: Any) -> None:
        super().__init__(**options)
        self.examples = tuple(examples)
        self._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")

    def format_help(self) -> str:
        """The help, with the examples as the last lines."""
        title = "example" if len(self.examples) == 1 else "examples"
        lines = "".join(f"  {line}\n" for line in self.examples)
        return super().format_help() + (f"\n{title}:\n{lines}" if lines else "")

    def error(self, message: str) -> NoReturn:
        """Print one line and exit with status 2."""
        self.exit(REFUSED, f"{self.prog}: {message}; see `{self.prog} --help`\n")
