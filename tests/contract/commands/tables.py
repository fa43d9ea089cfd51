"""Reads the tables of poses that commands print."""

import re


def table_head(text):
    """The names of the columns."""
    (line,) = (
        line
        for line in text.splitlines()
        if re.match(r"\s+poses?\s+(number\s+)?group\s", line)
    )
    return cells(line)


def table_rows(text):
    """The rows, each a dictionary by the names of the columns."""
    names = table_head(text)
    rows = [cells(line) for line in text.splitlines() if re.match(r"\s+\d", line)]
    return [dict(zip(names, row, strict=True)) for row in rows if len(row) > 3]


def cells(line):
    """What stands in the columns, which are at least two spaces apart."""
    return re.split(r"\s{2,}", line.strip())


def share(row):
    """Percentage in front of the bar."""
    return float(row["probability"].partition("%")[0])
