"""What all pages share: their head and style, escaping, and how numbers are written."""

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template

from ..text import listed, several
from . import words

ASSETS = Path(__file__).parent / "assets"

FILTERS: dict[str, Callable[..., str]] = {
    "percent": words.percent, "millimetres": words.millimetres, "units": words.units,
    "in_millimetres": words.in_millimetres, "degrees": words.degrees,
    "three_digits": words.three_digits, "listed": listed, "begin": words.begin,
    "several": several,
    "times": lambda drops: words.three_digits(drops) if math.isfinite(drops) else "no bound",
    "of_bar": lambda share: f"{0.0 if math.isnan(share) else 100.0 * share:.2f}"}


@cache
def template(name: str, folder: Path = ASSETS, **filters: Callable[..., str]) -> Template:
    """A page of a folder, with filters of its own, in which all that is put in is escaped."""
    loader = FileSystemLoader([ASSETS, folder])
    known = Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True,
                        undefined=StrictUndefined, keep_trailing_newline=True)
    # Style or script of a file, as it is.
    known.globals.update(asset=lambda file: loader.get_source(known, file)[0],
                         between=words.between, several=several)
    known.filters.update(FILTERS, is_finite=math.isfinite, **filters)
    return known.get_template(name)
