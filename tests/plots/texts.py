"""Where the texts of a drawn figure lie."""

from __future__ import annotations

from itertools import combinations

from matplotlib.text import Text


def texts(figure):
    """Every text that is shown, with its box in pixels."""
    found = []
    for text in figure.findobj(Text):
        box = Text.get_window_extent(text) if text.get_text() and text.get_visible() else None
        if box is not None and _shown(text, figure):
            found.append((text, box))
    return found


def overlapping(figure):
    """Pairs of texts that cover each other."""
    return [(one.get_text(), other.get_text())
            for (one, a), (other, b) in combinations(texts(figure), 2)
            if a.x0 < b.x1 and b.x0 < a.x1 and a.y0 < b.y1 and b.y0 < a.y1]


def clipped(figure):
    """Texts that do not lie within the figure."""
    page = figure.bbox
    return [text.get_text() for text, box in texts(figure)
            if box.x0 < 0.0 or box.y0 < 0.0 or box.x1 > page.x1 or box.y1 > page.y1]


def _shown(text, figure):
    """Tick labels belong to the axes even where their ticks are not drawn."""
    for axes in figure.axes:
        for axis, ends in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                if text is tick.label1:
                    return tick.label1.get_visible() and ends[0] <= tick.get_loc() <= ends[1]
                if text is tick.label2:
                    return False
    return True


def figure_texts(figure):
    """All that is written outside of the axes: title and common labels."""
    return "\n".join(text.get_text() for text in figure.texts)
