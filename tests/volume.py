"""Large volumes of cases: a few of them in every run, the others among the long tests."""

from __future__ import annotations

import pytest


def few_quick(cases, few):
    """Parameters of which all but the first few are long."""
    return [case if place < few else pytest.param(case, marks=pytest.mark.long)
            for place, case in enumerate(cases)]
