"""Pieces of HTML."""

from __future__ import annotations

import base64
import math
import re
from collections.abc import Iterable, Sequence
from html import escape

UNIT = re.compile(r"(?<=\d) (?=%|mm\b)")
"""The space between a number and its unit, where a line must not end."""


def text(value: object) -> str:
    """Text as HTML shows it, numbers kept together with their units."""
    return UNIT.sub("\N{NO-BREAK SPACE}", verbatim(value))


def verbatim(value: object) -> str:
    """Text as it is: for what is copied, and for attributes."""
    return escape(str(value), quote=True)


def element(tag: str, inside: str, css: str = "", **attributes: str) -> str:
    """An element; `inside` is HTML already."""
    named = {"class": css, **attributes} if css else attributes
    given = "".join(f' {name.rstrip("_").replace("_", "-")}="{verbatim(value)}"'
                    for name, value in named.items())
    return f"<{tag}{given}>{inside}</{tag}>"


def section(title: str, *inside: str, css: str = "") -> str:
    """A part of the page under a heading."""
    return element("section", element("h2", text(title)) + "".join(inside), css)


def paragraph(words: str, css: str = "") -> str:
    """Words as a paragraph."""
    return element("p", text(words), css)


def picture(data: bytes, kind: str, alternative: str, css: str = "") -> str:
    """An image that is part of the page.

    Parameters
    ----------
    data : bytes
        The file.
    kind : str
        `png` or `svg+xml`.
    alternative : str
        What it shows, in words.
    css : str
        Class.
    """
    source = f"data:image/{kind};base64,{base64.b64encode(data).decode()}"
    given = f' class="{verbatim(css)}"' if css else ""
    return f'<img{given} alt="{verbatim(alternative)}" src="{source}">'


def figure(image: str, caption: str, css: str = "") -> str:
    """An image with words below it."""
    return element("figure", element("div", image, "wide") + element("figcaption", text(caption)),
                   css)


def table(heads: Sequence[str], rows: Iterable[Sequence[str]], css: str = "") -> str:
    """A table that can be pushed sideways where the page is narrow; cells are HTML."""
    head = element("tr", "".join(element("th", one, scope="col") for one in heads))
    body = "".join(element("tr", "".join(element("td", cell) for cell in row)) for row in rows)
    return element("div", element("table", element("thead", head) + element("tbody", body), css),
                   "wide")


def percent(share: float) -> str:
    """A probability in percent; a dash where it is not known."""
    return "\N{EN DASH}" if math.isnan(share) else f"{100.0 * share:.1f} %"


def between(low: float, high: float) -> str:
    """A 90 % interval in percent."""
    if math.isnan(low) or math.isnan(high):
        return "\N{EN DASH}"
    digits = 1 if high >= 0.01 else 2
    return f"{100.0 * low:.{digits}f} to {100.0 * high:.{digits}f} %"


def millimetres(metres: float) -> str:
    """A length; words where it has no bound."""
    if not math.isfinite(metres):
        return "no other pose"
    return f"{in_millimetres(metres)} mm"


def in_millimetres(metres: float) -> str:
    """A length in millimetres without the unit, and never with an exponent."""
    return f"{1e3 * metres:.4g}" if metres < 10.0 else f"{1e3 * metres:.0f}"


def three_digits(value: float) -> str:
    """A number with three digits, zeros included; all of them where it has more."""
    return f"{value:#.3g}".rstrip(".") if value < 999.5 else f"{value:.0f}"


def degrees(radians: float) -> str:
    """An angle with three digits."""
    return f"{math.degrees(radians):.3g}\N{DEGREE SIGN}"
